#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/common/fem/sample_elements.hpp"
#include "tests/common/fem/test_help.hpp"

namespace ricochet::fem {
namespace {

using sample::message_of;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(GradedCoordinates, AreUniformWithGradingOne) {
  const std::vector<double> x = graded_coordinates(0.5, 2.0, 4, 1.0);
  EXPECT_THAT(x, ElementsAre(0.5, 1.0, 1.5, 2.0, 2.5));
}

TEST(GradedCoordinates, GrowGeometricallyToTheGivenRatio) {
  for (const double grading : {0.05, 0.999999, 20.0}) {
    const std::vector<double> x = graded_coordinates(-1.0, 3.0, 7, grading);
    ASSERT_EQ(x.size(), 8U);
    EXPECT_EQ(x.front(), -1.0);
    EXPECT_EQ(x.back(), 2.0);
    EXPECT_NEAR((x[7] - x[6]) / (x[1] - x[0]), grading, 1e-10 * grading);
    for (std::size_t i = 2; i < x.size(); ++i) {
      EXPECT_NEAR((x[i] - x[i - 1]) / (x[i - 1] - x[i - 2]), std::pow(grading, 1.0 / 6.0), 1e-9);
    }
  }
}

TEST(GradedCoordinates, OfOneElementIgnoreTheGrading) {
  EXPECT_THAT(graded_coordinates(0.0, 2.0, 1, 9.0), ElementsAre(0.0, 2.0));
}

TEST(GradedCoordinates, RefuseWhatMakesNoMesh) {
  struct Case {
    double length;
    int count;
    double grading;
  };
  for (const auto& wrong : {Case{1.0, 0, 1.0}, Case{0.0, 2, 1.0}, Case{-1.0, 2, 1.0}, Case{1.0, 2, 0.0},
                            Case{std::numeric_limits<double>::quiet_NaN(), 2, 1.0}}) {
    EXPECT_THAT(message_of([&] { (void)graded_coordinates(0.0, wrong.length, wrong.count, wrong.grading); }),
                HasSubstr("at least one element, a positive length and a positive grading"));
  }
}

TEST(BarMesh, HasItsEndsAsSurfaces) {
  const Mesh mesh = bar_mesh({1.0, 1.5, 3.0});
  EXPECT_EQ(mesh.elements.size(), 2U);
  EXPECT_EQ(mesh.elements[1], (Element{ElementKind::bar, {1, 2}}));
  EXPECT_THAT(mesh.surfaces.at("start"), ElementsAre(Face{0}));
  EXPECT_THAT(mesh.surfaces.at("end"), ElementsAre(Face{2}));
  check_mesh(mesh, "rod");
}

TEST(QuadrilateralMesh, SurfacesHaveOutwardNormalsAndTheAreaOfTheCylinder) {
  const Mesh mesh = quadrilateral_mesh(Model::axisymmetric, graded_coordinates(0.01, 0.02, 3, 2.0),
                                       graded_coordinates(-0.04, 0.05, 5, 0.5));
  check_mesh(mesh, "tube");
  const Section section = sample::section(Model::axisymmetric);
  const double pi = std::numbers::pi;
  const std::map<std::string, std::pair<Eigen::Vector2d, double>> expected = {
      {"start", {{0.0, -1.0}, pi * (0.03 * 0.03 - 0.01 * 0.01)}},
      {"end", {{0.0, 1.0}, pi * (0.03 * 0.03 - 0.01 * 0.01)}},
      {"inner", {{-1.0, 0.0}, 2.0 * pi * 0.01 * 0.05}},
      {"outer", {{1.0, 0.0}, 2.0 * pi * 0.03 * 0.05}}};
  ASSERT_EQ(mesh.surfaces.size(), expected.size());
  for (const auto& [name, edges] : mesh.surfaces) {
    const auto& [normal, area] = expected.at(name);
    double sum = 0.0;
    for (const Face& edge : edges) {
      EXPECT_LT((face_normal(mesh, edge).head<2>() - normal).norm(), 1e-14) << name;
      const FaceArea of_nodes = face_area(section, mesh, edge);
      sum += of_nodes[0] + of_nodes[1];
    }
    EXPECT_NEAR(sum, area, 1e-13 * area) << name;
  }
}

TEST(Mesh, BlockHasSixSurfacesWithOutwardNormals) {
  const Mesh mesh = block_mesh(graded_coordinates(0.0, 0.02, 3, 2.0), graded_coordinates(0.0, 0.03, 2, 1.0),
                               graded_coordinates(-0.04, 0.05, 5, 0.5));
  check_mesh(mesh, "block");
  EXPECT_EQ(mesh.elements.size(), 30U);
  const std::map<std::string, std::pair<Eigen::Vector3d, double>> expected = {
      {"start", {{0.0, 0.0, -1.0}, 0.02 * 0.03}}, {"end", {{0.0, 0.0, 1.0}, 0.02 * 0.03}},
      {"inner", {{-1.0, 0.0, 0.0}, 0.03 * 0.05}}, {"outer", {{1.0, 0.0, 0.0}, 0.03 * 0.05}},
      {"front", {{0.0, -1.0, 0.0}, 0.02 * 0.05}}, {"back", {{0.0, 1.0, 0.0}, 0.02 * 0.05}}};
  ASSERT_EQ(mesh.surfaces.size(), expected.size());
  for (const Mesh& tested : {mesh, sample::tetrahedra_of(mesh)}) {
    check_mesh(tested, "block");
    for (const auto& [name, faces] : tested.surfaces) {
      const auto& [normal, area] = expected.at(name);
      double sum = 0.0;
      for (const Face& face : faces) {
        EXPECT_LT((face_normal(tested, face) - normal).norm(), 1e-14) << name;
        for (const double of_node : face_area(sample::section(Model::solid), tested, face)) sum += of_node;
      }
      EXPECT_NEAR(sum, area, 1e-13 * area) << name;
    }
  }
}

TEST(SurfaceNodes, AreSortedAcrossAndNamedOnce) {
  const Mesh mesh = quadrilateral_mesh(Model::plane_strain, {0.0, 1.0, 2.0}, {0.0, 1.0, 2.0});
  EXPECT_THAT(surface_nodes(mesh, "end"), ElementsAre(6, 7, 8));
  EXPECT_THAT(surface_nodes(mesh, "inner"), ElementsAre(0, 3, 6));
  EXPECT_THAT(surface_nodes(bar_mesh({0.0, 1.0}), "end"), ElementsAre(1));
}

TEST(SurfaceNodes, RefuseAnUnknownSurfaceAndNameTheKnownOnes) {
  const Mesh mesh = quadrilateral_mesh(Model::plane_strain, {0.0, 1.0}, {0.0, 1.0});
  EXPECT_THAT(message_of([&] { (void)surface_nodes(mesh, "innner"); }),
              AllOf(HasSubstr("no surface \"innner\""), HasSubstr("end, inner, outer, start"),
                    HasSubstr("did you mean \"inner\"?")));
}

struct BadMesh {
  std::string name;
  Model model;
  std::vector<Eigen::Vector2d> position;
  std::vector<std::string> expected;

  friend void PrintTo(const BadMesh& bad, std::ostream* out) { *out << bad.name; }
};

class CheckOneElement : public testing::TestWithParam<BadMesh> {};

TEST_P(CheckOneElement, NamesBodyElementAndPlace) {
  const BadMesh& bad = GetParam();
  Mesh mesh;
  mesh.model = bad.model;
  for (const auto& x : bad.position) mesh.position.emplace_back(x[0], x[1], 0.0);
  const auto kinds = {ElementKind::bar, ElementKind::triangle, ElementKind::quadrilateral};
  mesh.elements = {{kinds.begin()[bad.position.size() - 2], {0, 1, 2, 3}}};
  const std::string text = message_of([&] { check_mesh(mesh, "target"); });
  EXPECT_THAT(text, HasSubstr("body \"target\""));
  for (const std::string& expected : bad.expected) EXPECT_THAT(text, HasSubstr(expected));
}

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
INSTANTIATE_TEST_SUITE_P(
    Meshes, CheckOneElement,
    testing::Values(
        BadMesh{"clockwise",
                Model::plane_strain,
                {{0, 0}, {0, 1}, {1, 1}, {1, 0}},
                {"element 0 is inverted", "(0.5, 0.5)"}},
        BadMesh{"concave", Model::plane_strain, {{0, 0}, {4, 0}, {1, 1}, {0, 4}}, {"not convex", "(x, y)"}},
        BadMesh{"crossed", Model::plane_strain, {{0, 0}, {1, 0}, {0, 1}, {1, 1}}, {"inverted"}},
        BadMesh{
            "two_nodes_at_one_place", Model::axisymmetric, {{0, 0}, {1, 0}, {1, 0}, {0, 1}}, {"has no area", "(r, z)"}},
        BadMesh{"flat", Model::plane_strain, {{0, 0}, {1, 0}, {2, 0}, {3, 0}}, {"has no area"}},
        BadMesh{"across_the_axis", Model::axisymmetric, {{-0.1, 0}, {1, 0}, {1, 1}, {0, 1}}, {"r = -0.1 m"}},
        BadMesh{"not_finite", Model::plane_strain, {{0, 0}, {1, 0}, {not_a_number, 1}, {0, 1}}, {"node 2", "finite"}},
        BadMesh{"clockwise_triangle", Model::plane_strain, {{0, 0}, {0, 1}, {1, 1}}, {"element 0 is inverted"}},
        BadMesh{"flat_triangle", Model::axisymmetric, {{0, 0}, {1, 1}, {2, 2}}, {"has no area", "(r, z) = (1, 1)"}},
        BadMesh{"bar_reversed", Model::bar, {{1, 0}, {0, 0}}, {"element 0 has no positive length", "x = 0.5 m"}},
        BadMesh{"bar_without_length", Model::bar, {{1, 0}, {1, 0}}, {"no positive length"}}),
    [](const auto& tested) { return tested.param.name; });

TEST(CheckWholeMesh, RefusesAMeshWithoutElements) {
  EXPECT_THAT(message_of([] { check_mesh(Mesh{}, "target"); }), HasSubstr("no elements"));
}

TEST(CheckWholeMesh, AcceptsVerySlenderElements) {
  check_mesh(quadrilateral_mesh(Model::plane_strain, {0.0, 1.0}, {0.0, 1e-4}), "film");
}

TEST(PeriodicMesh, ElementsReachAcrossTheEnd) {
  Mesh mesh = quadrilateral_mesh(Model::plane_strain, {0.0, 1.0, 2.0}, {0.0, 1.0});
  mesh.period_m = 3.0;
  mesh.elements.push_back({ElementKind::quadrilateral, {2, 0, 3, 5}});
  mesh.surfaces["start"].push_back({2, 0});
  check_mesh(mesh, "plate");
  ElementCoordinates expected(4, 2);
  expected << 2.0, 0.0, 3.0, 0.0, 3.0, 1.0, 2.0, 1.0;
  EXPECT_EQ(element_geometry(mesh, 2).x, expected);
  const Part part = sample::whole_part(mesh, {Model::plane_strain, 1.0});
  EXPECT_NEAR(part.lumped_mass.sum(), 3.0 * sample::steel.density_kg_m3, 1e-9);
  const Eigen::VectorXd force = traction_force(part, "start", {0.0, 2.0});
  EXPECT_NEAR(force.sum(), 6.0, 1e-14);
  EXPECT_NEAR(force[1], 2.0, 1e-15) << "every node of a periodic row carries the same";
}

}  // namespace
}  // namespace ricochet::fem
