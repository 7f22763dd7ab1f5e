#include <gtest/gtest.h>

#include "common/fem/natural_point.hpp"
#include "common/fem/part.hpp"
#include "tests/common/fem/sample_elements.hpp"

namespace ricochet::fem {
namespace {

Eigen::Vector3d place(const ElementGeometry& element, const NaturalPoint& at) {
  const ShapeValues values = shape_values(element.kind, at);
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    for (Eigen::Index c = 0; c < element.x.cols(); ++c) x[c] += values[i] * element.x(i, c);
  }
  return x;
}

std::vector<Mesh> meshes() {
  std::vector<Mesh> all;
  for (const Model model : {Model::bar, Model::plane_strain, Model::axisymmetric, Model::solid})
    all.push_back(sample::distorted_mesh(model));
  all.push_back(sample::triangulated(all[1]));
  all.push_back(sample::tetrahedra_of(all[3]));
  return all;
}

TEST(NaturalPoint, IsFoundInEveryKindOfDistortedElement) {
  for (const Mesh& mesh : meshes()) {
    for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
      const auto element = element_geometry(mesh, e);
      const auto& kind = traits(element.kind);
      std::vector<NaturalPoint> points(kind.corner.begin(), kind.corner.end());
      points.push_back(kind.centre);
      points.push_back(0.3 * points[0] + 0.7 * kind.centre);
      for (const auto& at : points) {
        const auto found = natural_point(element, place(element, at));
        ASSERT_TRUE(found) << "of an element of " << kind.nodes << " nodes";
        EXPECT_LT((*found - at).norm(), 1e-9);
        EXPECT_NEAR(shape_values(element.kind, at).sum(), 1.0, 1e-15);
      }
    }
  }
}

TEST(NaturalPoint, OutsideIsNone) {
  for (const Mesh& mesh : meshes()) {
    const auto element = element_geometry(mesh, 0);
    const auto& kind = traits(element.kind);
    for (int corner = 0; corner < kind.nodes; ++corner) {
      const NaturalPoint beyond = kind.centre + 1.01 * (kind.corner[at(corner)] - kind.centre);
      EXPECT_FALSE(natural_point(element, place(element, beyond)));
    }
  }
}

}  // namespace
}  // namespace ricochet::fem
