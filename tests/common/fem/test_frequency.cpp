#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <stdexcept>

#include "common/fem/stiffness_product.hpp"
#include "tests/common/fem/sample_elements.hpp"
#include "tests/common/fem/test_help.hpp"

namespace ricochet::fem {
namespace {

double dense_max_frequency_squared(const Part& part, const std::vector<bool>& fixed) {
  const int dofs_per_node = components(part.mesh.model);
  Eigen::MatrixXd scaled = part.stiffness;
  for (Eigen::Index i = 0; i < scaled.rows(); ++i) {
    for (Eigen::Index j = 0; j < scaled.cols(); ++j) {
      scaled(i, j) /= std::sqrt(part.lumped_mass[i / dofs_per_node] * part.lumped_mass[j / dofs_per_node]);
      if (fixed[static_cast<std::size_t>(i)] || fixed[static_cast<std::size_t>(j)]) scaled(i, j) = 0.0;
    }
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues().maxCoeff();
}

double lanczos(const Part& part, const std::vector<bool>& fixed, double tolerance = 1e-6) {
  return max_frequency_squared(part.stiffness, part.lumped_mass, components(part.mesh.model), fixed, tolerance);
}

TEST(MaxFrequency, AgreesWithADenseSolverFromBelow) {
  for (const Model model : sample::every_model) {
    const Part part = sample::distorted_part(model);
    std::vector<bool> fixed(static_cast<std::size_t>(part.dofs()), false);
    for (const int fixed_every : {0, 3, 2}) {
      for (int i = 0; i < part.dofs(); ++i) {
        fixed[static_cast<std::size_t>(i)] = fixed_every > 0 && i % fixed_every == 0;
      }
      const double exact = dense_max_frequency_squared(part, fixed);
      for (const double tolerance : {1e-3, 1e-6, 1e-10}) {
        const double found = lanczos(part, fixed, tolerance);
        EXPECT_LE(found, exact * (1.0 + 1e-12)) << sample::name(model);
        EXPECT_GE(found, exact * (1.0 - tolerance)) << sample::name(model);
      }
    }
  }
}

/// A few products give a lower bound, which is most of it; enough of them give it all.
TEST(FrequencyAtLeast, IsALowerBoundThatIsCloseAfterTenProducts) {
  for (const Model model : sample::every_model) {
    const Part part = sample::distorted_part(model);
    const int dofs_per_node = components(part.mesh.model);
    const StiffnessProduct product(part.stiffness, dofs_per_node);
    std::vector<bool> fixed(static_cast<std::size_t>(part.dofs()), false);
    fixed[0] = true;
    const double exact = dense_max_frequency_squared(part, fixed);
    const auto after = [&](int products) {
      return frequency_squared_at_least(product, part.lumped_mass, dofs_per_node, fixed, products);
    };
    EXPECT_LE(after(1), exact * (1.0 + 1e-12)) << sample::name(model);
    EXPECT_LE(after(10), exact * (1.0 + 1e-12)) << sample::name(model);
    EXPECT_GE(after(10), 0.9 * exact) << sample::name(model);
    EXPECT_NEAR(after(part.dofs()), exact, 1e-6 * exact) << sample::name(model);
    const std::vector<bool> none(fixed.size(), true);
    EXPECT_EQ(frequency_squared_at_least(product, part.lumped_mass, dofs_per_node, none, 10), 0.0);
  }
}

TEST(MaxFrequency, IsThatOfTheSummedMass) {
  const Part part = sample::distorted_part(Model::plane_strain);
  const std::vector<bool> free(static_cast<std::size_t>(part.dofs()), false);
  const double found = max_frequency_squared(part.stiffness, 4.0 * part.lumped_mass, 2, free);
  EXPECT_NEAR(found, 0.25 * lanczos(part, free), 1e-5 * found);
}

TEST(MaxFrequency, IsTheSameToTheLastBitOnEveryCall) {
  const Part part = sample::distorted_part(Model::axisymmetric);
  const std::vector<bool> free(static_cast<std::size_t>(part.dofs()), false);
  EXPECT_EQ(lanczos(part, free), lanczos(part, free));
}

TEST(MaxFrequency, OfTinyProblemsIsExact) {
  const Part part = sample::whole_part(bar_mesh({0.0, 0.1}), sample::section(Model::bar));
  const double c = longitudinal_wave_speed(Model::bar, sample::steel);
  EXPECT_NEAR(lanczos(part, {false, false}), 4.0 * c * c / 0.01, 1e-9 * c * c / 0.01);
  EXPECT_NEAR(lanczos(part, {true, false}), 2.0 * c * c / 0.01, 1e-9 * c * c / 0.01);
  EXPECT_EQ(lanczos(part, {true, true}), 0.0);
}

// A uniform bar is the hardest case: its highest frequencies lie closest together. Exact: 2 c/h.
TEST(MaxFrequency, OfALongUniformBarIsExact) {
  const Part part = sample::whole_part(bar_mesh(graded_coordinates(0.0, 1.0, 3000, 1.0)), sample::section(Model::bar));
  const double exact = std::pow(2.0 * 3000.0 * longitudinal_wave_speed(Model::bar, sample::steel), 2);
  const double found = lanczos(part, std::vector<bool>(3001, false));
  EXPECT_LE(found, exact * (1.0 + 1e-10));
  EXPECT_GE(found, exact * (1.0 - 1e-6));
}

TEST(MaxFrequency, OfThirtyThousandUnknownsTightensTheElementBound) {
  const Mesh mesh = quadrilateral_mesh(Model::axisymmetric, graded_coordinates(0.0, 5e-3, 100, 20.0),
                                       graded_coordinates(0.0, 0.08, 150, 20.0));
  const Part part = sample::whole_part(mesh, sample::section(Model::axisymmetric));
  std::vector<bool> fixed(static_cast<std::size_t>(part.dofs()), false);
  for (int node = 0; node < part.nodes(); ++node) {
    if (mesh.position[static_cast<std::size_t>(node)][0] == 0.0) fixed[2 * static_cast<std::size_t>(node)] = true;
  }
  const double element_bound = 4.0 / std::pow(element_critical_time_step(part), 2);
  const double coarse = lanczos(part, fixed, 1e-4), fine = lanczos(part, fixed, 1e-9);
  EXPECT_LE(fine, element_bound);
  EXPECT_LE(coarse, fine * (1.0 + 1e-12));
  EXPECT_GE(coarse, fine * (1.0 - 1e-4));
}

TEST(MaxFrequency, RefusesAFreeNodeWithoutMassAndAStiffnessThatIsNotFinite) {
  Part part = sample::distorted_part(Model::bar);
  std::vector<bool> fixed(static_cast<std::size_t>(part.dofs()), false);
  part.lumped_mass[2] = 0.0;
  EXPECT_THROW((void)lanczos(part, fixed), std::invalid_argument);
  fixed[2] = true;
  EXPECT_GT(lanczos(part, fixed), 0.0);
  part.stiffness.coeffs()[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)lanczos(part, fixed), SolverError);
}

}  // namespace
}  // namespace ricochet::fem
