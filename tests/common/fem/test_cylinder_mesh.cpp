#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "tests/common/fem/sample_elements.hpp"
#include "tests/common/fem/test_help.hpp"

namespace ricochet::fem {
namespace {

constexpr double cylinder_radius = 0.02, cylinder_length = 0.05;

Mesh sample_cylinder(int across, double grading = 1.0, int along = 2, double grading_along = 1.0) {
  return cylinder_mesh(graded_coordinates(0.0, cylinder_radius, across, grading),
                       graded_coordinates(-0.01, cylinder_length, along, grading_along));
}

double cylinder_volume(const Mesh& mesh) {
  double sum = 0.0;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const ElementGeometry geometry = element_geometry(mesh, e);
    sum += traits(geometry.kind).volume(sample::section(Model::solid), geometry.x).sum();
  }
  return sum;
}

TEST(CylinderMesh, HasTheVolumeOfACylinderToSecondOrder) {
  const double exact = std::numbers::pi * cylinder_radius * cylinder_radius * cylinder_length;
  double coarser = 0.0;
  for (const int across : {2, 4, 8, 16, 32}) {
    const double missing = 1.0 - cylinder_volume(sample_cylinder(across)) / exact,
                 angle = std::numbers::pi / (2.0 * across);
    EXPECT_NEAR(missing, 1.0 - std::sin(angle) / angle, 1e-10) << "a polygon of 4 corners per element on the radius";
    if (coarser > 0.0) {
      EXPECT_NEAR(std::log2(coarser / missing), 2.0, 0.04) << across;
    }
    coarser = missing;
  }
}

/// The smallest Jacobian of the elements over their largest, each by its volume.
TEST(CylinderMesh, HasGoodElementsHoweverManyItHas) {
  for (const int across : {1, 2, 3, 4, 5, 8, 13, 40}) {
    const Mesh mesh = sample_cylinder(across, 1.0, 1);
    check_mesh(mesh, "cylinder");
    double worst = 1.0;
    for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
      const ElementGeometry element = element_geometry(mesh, e);
      double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
      for (const NaturalPoint& corner : traits(element.kind).corner) {
        const double jacobian = traits(element.kind).jacobian(element.x, corner);
        smallest = std::min(smallest, jacobian);
        largest = std::max(largest, jacobian);
      }
      worst = std::min(worst, smallest / largest);
    }
    EXPECT_GT(worst, 0.37) << across;
  }
}

TEST(CylinderMesh, IsSoundWithAnyGrading) {
  for (const int across : {1, 2, 3, 7, 20})
    for (const double grading : {0.05, 0.5, 2.0, 20.0})
      check_mesh(sample_cylinder(across, grading, 3, 1.0 / grading), "cylinder");
}

TEST(CylinderMesh, IsItsOwnImageUnderTheSymmetriesOfTheSquare) {
  for (const int across : {1, 2, 3, 6, 9}) {
    const Mesh mesh = sample_cylinder(across, 3.0);
    std::set<std::array<double, 3>> nodes;
    for (const auto& x : mesh.position) nodes.insert({x[0], x[1], x[2]});
    EXPECT_EQ(nodes.size(), mesh.position.size()) << "no node twice";
    for (const auto& x : mesh.position) {
      for (const auto& image : {std::array{-x[0], x[1], x[2]}, {x[0], -x[1], x[2]}, {x[1], x[0], x[2]}})
        EXPECT_EQ(nodes.count(image), 1U) << across << ' ' << x.transpose();
    }
  }
}

TEST(CylinderMesh, HasThreeSurfacesWithOutwardNormals) {
  for (const int across : {1, 2, 5}) {
    const Mesh mesh = sample_cylinder(across, 1.0, 3, 2.0);
    ASSERT_EQ(mesh.surfaces.size(), 3U);
    const double base = cylinder_volume(mesh) / cylinder_length;
    std::map<std::string, double> area;
    for (const auto& [name, faces] : mesh.surfaces) {
      for (const Face& face : faces) {
        const FaceArea of_nodes = face_area(sample::section(Model::solid), mesh, face);
        area[name] += std::accumulate(of_nodes.begin(), of_nodes.end(), 0.0);
        Eigen::Vector3d out = mesh.position[at(face[0])] + mesh.position[at(face[2])];
        out[2] = 0.0;
        if (name == "start") out = -Eigen::Vector3d::UnitZ();
        if (name == "end") out = Eigen::Vector3d::UnitZ();
        EXPECT_LT((face_normal(mesh, face) - out.normalized()).norm(), 1e-13) << name;
      }
    }
    EXPECT_NEAR(area.at("start"), base, 1e-10 * base);
    EXPECT_NEAR(area.at("end"), base, 1e-10 * base);
    const double chord = 2.0 * cylinder_radius * std::sin(std::numbers::pi / (8.0 * core_of_cylinder(across)));
    EXPECT_NEAR(area.at("outer"), 8.0 * core_of_cylinder(across) * chord * cylinder_length, 1e-10 * base);
    for (const int node : surface_nodes(mesh, "outer"))
      EXPECT_NEAR(mesh.position[at(node)].head<2>().norm(), cylinder_radius, 1e-15);
  }
}

TEST(CylinderMesh, HasTheLinesOnTheAxes) {
  const auto across = graded_coordinates(0.0, cylinder_radius, 5, 4.0);
  const Mesh mesh = cylinder_mesh(across, {0.0, 1.0});
  for (const double r : across) {
    const auto on_axis = [&](const Eigen::Vector3d& x) { return x[1] == 0.0 && std::abs(x[0] - r) < 1e-16; };
    EXPECT_EQ(std::count_if(mesh.position.begin(), mesh.position.end(), on_axis), 2) << r;
  }
}

}  // namespace
}  // namespace ricochet::fem
