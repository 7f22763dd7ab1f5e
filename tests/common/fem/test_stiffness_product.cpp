#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "common/fem/part.hpp"
#include "common/fem/stiffness_product.hpp"
#include "tests/common/fem/sample_elements.hpp"
#include "tests/support/places.hpp"

namespace ricochet::fem {
namespace {

Part whole(const Mesh& mesh) {
  std::vector<int> elements;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) elements.push_back(e);
  return extract_part(mesh, "body", {mesh.model, 0.7}, {2e11, mesh.model == Model::bar ? 0.0 : 0.3, 7800.0}, elements);
}

double largest_difference(const Part& part) {
  const StiffnessProduct product(part.stiffness, components(part.mesh.model));
  Eigen::VectorXd u(part.dofs()), result = Eigen::VectorXd::Constant(part.dofs(), 1e99);
  for (int i = 0; i < part.dofs(); ++i) u[i] = std::sin(1.7 * i) + 0.3;
  product.multiply(u, result);
  const Eigen::VectorXd expected = part.stiffness * u;
  return (result - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

TEST(StiffnessProduct, EqualsTheSparseProductOnStructuredMeshes) {
  for (const Model model : {Model::plane_strain, Model::axisymmetric}) {
    for (const int across : {1, 2, 5, 10}) {  // sizes that do and do not fill whole slices
      const Part part = whole(
          quadrilateral_mesh(model, graded_coordinates(0.0, 0.1, across, 2.0), graded_coordinates(0.0, 1.0, 7, 1.0)));
      EXPECT_LT(largest_difference(part), 1e-14) << across;
    }
  }
  EXPECT_LT(largest_difference(whole(bar_mesh(graded_coordinates(0.0, 1.0, 13, 1.0)))), 1e-14);
}

Mesh block(int x, int y, int z) {
  return block_mesh(graded_coordinates(0.0, 0.1, x, 1.0), graded_coordinates(0.0, 0.13, y, 1.0),
                    graded_coordinates(0.3, 1.0, z, 1.0));
}

TEST(StiffnessProduct, EqualsTheSparseProductOfSolids) {
  for (const Mesh& mesh : {block(3, 2, 7), sample::distorted_block(), sample::tetrahedra_of(sample::distorted_block())})
    EXPECT_LT(largest_difference(whole(mesh)), 1e-14);
}

// 27 places that a node of a block can have: inside, and on its faces, edges and corners.
TEST(NodeStencils, AreStoredOnceForCopiesOfAnElement) {
  const Part part = whole(block(5, 4, 9));
  EXPECT_EQ(NodeStencils(part.stiffness).nodes(), 6 * 5 * 10);
  EXPECT_EQ(NodeStencils(part.stiffness).distinct(), 27);
  const Part uneven = whole(sample::distorted_block());
  EXPECT_GT(NodeStencils(uneven.stiffness).distinct(), uneven.nodes() / 2);
}

// Eleven nodes across: where a slice of four begins among them repeats every eleven slices.
TEST(StiffnessProduct, StoresSlicesAmongCopiesOfAnElementOnce) {
  for (const Model model : {Model::plane_strain, Model::axisymmetric}) {
    const Part part = whole(
        quadrilateral_mesh(model, graded_coordinates(0.0, 0.005, 10, 2.0), graded_coordinates(-0.08, 0.08, 160, 1.0)));
    const StiffnessProduct product(part.stiffness, 2);
    EXPECT_EQ(product.slices(), 11 * 161 / 4);
    EXPECT_LE(product.distinct_slices(), 11 + 3 + 3);  // and those that the two ends are neighbours of
  }
  const Part uneven = whole(read_gmsh(test::source_folder() + "/configs/striker.msh", Model::axisymmetric, "striker"));
  const StiffnessProduct product(uneven.stiffness, 2);
  EXPECT_GT(product.distinct_slices(), product.slices() / 2);
}

TEST(StiffnessProduct, EqualsTheSparseProductOnAnUnstructuredMesh) {
  const std::string path = test::source_folder() + "/configs/striker.msh";
  EXPECT_LT(largest_difference(whole(read_gmsh(path, Model::axisymmetric, "striker"))), 1e-14);
  EXPECT_LT(largest_difference(whole(read_gmsh(path, Model::axisymmetric, "anvil"))), 1e-14);
}

TEST(StiffnessProduct, OfSomeSlicesHasTheSameBitsAndLeavesTheOtherRows) {
  for (const Part& part : {whole(bar_mesh(graded_coordinates(0.0, 1.0, 20, 1.0))),
                           whole(quadrilateral_mesh(Model::axisymmetric, graded_coordinates(0.0, 0.1, 5, 2.0),
                                                    graded_coordinates(0.0, 1.0, 7, 1.0))),
                           whole(block(3, 2, 7))}) {
    const StiffnessProduct product(part.stiffness, components(part.mesh.model));
    const int n = part.dofs(), slice = StiffnessProduct::rows_of_slice(components(part.mesh.model));
    Eigen::VectorXd u(n), all(n);
    for (int i = 0; i < n; ++i) u[i] = std::sin(1.7 * i);
    product.multiply(u, all);
    for (const auto& [first, last] :
         {std::pair{0, slice}, {slice, n}, {2 * slice, n}, {slice, 2 * slice}, {slice, slice}}) {
      Eigen::VectorXd some = Eigen::VectorXd::Constant(n, 1e99), expected = some;
      expected.segment(first, last - first) = all.segment(first, last - first);
      product.multiply(u, some, first, last);
      EXPECT_EQ(some, expected) << first << ' ' << last;
    }
  }
}

// A body that has flown far: forces as of the body at its place, and no sum of them that would push it on.
TEST(StiffnessProduct, HasTheSameBitsByAnyNumberOfThreads) {
  for (const Part& part : {whole(bar_mesh(graded_coordinates(0.0, 1.0, 9001, 1.0))),
                           whole(quadrilateral_mesh(Model::axisymmetric, graded_coordinates(0.0, 0.1, 50, 2.0),
                                                    graded_coordinates(0.0, 1.0, 101, 1.0))),
                           whole(block(12, 13, 19))}) {
    StiffnessProduct product(part.stiffness, components(part.mesh.model));
    const int n = part.dofs(), slice = StiffnessProduct::rows_of_slice(components(part.mesh.model));
    ASSERT_GT(n, 8000);  // else there is nothing for a second thread
    Eigen::VectorXd u(n), alone(n);
    for (int i = 0; i < n; ++i) u[i] = std::sin(1.7 * i);
    product.multiply(u, alone);
    for (const int threads : {1, 2, 3, 7}) {
      product.compute_with(std::make_shared<Parallel>(threads));
      Eigen::VectorXd together = Eigen::VectorXd::Constant(n, 1e99), expected = alone;
      product.multiply(u, together);
      EXPECT_EQ(together, alone) << threads;
      together.setConstant(1e99);
      product.multiply(u, together, slice, n);
      expected.head(slice).setConstant(1e99);
      EXPECT_EQ(together, expected) << threads;
    }
  }
}

TEST(StiffnessProduct, ATranslationMakesNoForce) {
  const auto mesh = [](Model model, int along) {
    return quadrilateral_mesh(model, graded_coordinates(0.0, 0.1, 2, 2.0), graded_coordinates(0.0, 1.0, along, 1.0));
  };
  std::vector<Part> parts = {whole(bar_mesh(graded_coordinates(0.0, 1.0, 13, 2.0)))};
  for (const Model model : {Model::plane_strain, Model::axisymmetric}) {
    for (const int along : {6, 7}) parts.push_back(whole(mesh(model, along)));  // the last slice is not and is full
  }
  parts.push_back(whole(block(3, 2, 7)));
  for (const Part& part : parts) {
    const int n = components(part.mesh.model);
    const StiffnessProduct product(part.stiffness, n);
    Eigen::VectorXd near(part.dofs()), far(part.dofs()), force(part.dofs()), force_far(part.dofs());
    for (int i = 0; i < part.dofs(); ++i) {
      near[i] = std::ldexp(std::floor(1024 * std::sin(1.7 * i)), -30);  // exact beside the 2^10 m that it flies
      far[i] = near[i] + (i % n == n - 1 ? 1024.0 : 0.0);               // along the axis, free in every model
    }
    product.multiply(near, force);
    product.multiply(far, force_far);
    EXPECT_LE((force - force_far).cwiseAbs().maxCoeff(), 1e-15 * force.cwiseAbs().maxCoeff());
  }
}

TEST(StiffnessProduct, ReadsNeighboursInARowOnAWellNumberedMesh) {
  const Part part = whole(quadrilateral_mesh(Model::axisymmetric, graded_coordinates(0.0, 0.1, 10, 1.0),
                                             graded_coordinates(0.0, 1.0, 50, 1.0)));
  EXPECT_GT(StiffnessProduct(part.stiffness, 2).contiguous_share(), 0.95);
}

}  // namespace
}  // namespace ricochet::fem
