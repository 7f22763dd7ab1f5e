#include <gmock/gmock.h>

#include "common/fem/axial_stress.hpp"
#include "tests/common/fem/sample_elements.hpp"

namespace ricochet::fem {
namespace {

using testing::DoubleNear;
using testing::Each;
using testing::Pointwise;

/// Stress of a body strained along its axis alone: E, or lambda + 2 mu where it cannot narrow.
double axial_modulus(Model model) {
  const double e = sample::steel.youngs_modulus_pa, nu = sample::steel.poisson_ratio;
  return model == Model::bar ? e : e * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
}

Eigen::VectorXd stretched(const Mesh& mesh, double strain) {
  const int axis = components(mesh.model) - 1;
  return sample::nodal(
      mesh, [&](const auto& x) -> Eigen::Vector3d { return strain * x[axis] * Eigen::Vector3d::Unit(axis); });
}

std::vector<double> list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

TEST(AxialLayers, AreTheElementsAlongTheAxisOrAWholeFractionOfThem) {
  const Section section = sample::section(Model::axisymmetric);
  const auto mesh = quadrilateral_mesh(Model::axisymmetric, graded_coordinates(0.0, 0.005, 10, 1.0),
                                       graded_coordinates(-0.08, 0.08, 160, 1.0));
  EXPECT_EQ(axial_layers(mesh, section, 200).size(), 160);
  const auto layers = axial_layers(mesh, section, 100);
  EXPECT_EQ(layers.size(), 80);
  EXPECT_DOUBLE_EQ(layers.border.front(), -0.08);
  EXPECT_NEAR(layers.border.back(), 0.0, 1e-17);
  const double volume = std::numbers::pi * 0.005 * 0.005 * 1e-3;
  EXPECT_THAT(layers.volume_m3, Each(DoubleNear(volume, 1e-12 * volume)));
  EXPECT_EQ(axial_layers(bar_mesh(graded_coordinates(0.0, 1.0, 7, 1.0)), sample::section(Model::bar), 1).size(), 1);
}

TEST(AxialStress, IsExactForAUniformStrainInDistortedElements) {
  for (const Model model : sample::every_model) {
    const auto part = sample::distorted_part(model);
    const auto layers = axial_layers(part.mesh, part.section, 100);
    const double expected = 1e-3 * axial_modulus(model);
    const Eigen::VectorXd stress = axial_stress_shares(part, layers) * stretched(part.mesh, 1e-3);
    EXPECT_THAT(list(stress), Each(DoubleNear(expected, 1e-9 * expected))) << sample::name(model);
  }
}

TEST(AxialStress, OfALayerThatCutsElementsIsTheMeanByVolume) {
  const auto part = sample::whole_part(bar_mesh({0.0, 1.0, 4.0}), sample::section(Model::bar));  // two layers of 2 m
  const auto layers = axial_layers(part.mesh, part.section, 100);
  ASSERT_EQ(layers.size(), 2);
  const Eigen::Vector3d u(0.0, 1e-3, 1e-3 + 6e-3);  // strains 1e-3 and 2e-3
  const double e = sample::steel.youngs_modulus_pa;
  EXPECT_THAT(list(axial_stress_shares(part, layers) * u), Pointwise(DoubleNear(1.0), {1.5e-3 * e, 2e-3 * e}));
}

TEST(AxialStress, SharesOfThePartsOfABodyAddUp) {
  for (const Model model : sample::every_model) {
    const auto mesh = sample::distorted_mesh(model);
    const auto section = sample::section(model);
    const auto whole = sample::whole_part(mesh, section);
    const auto layers = axial_layers(mesh, section, 100);
    const auto field = [](const auto& x) {
      return Eigen::Vector3d(1e-3 * x[1] + x[0] * x[0], 2e-3 * x[1] * x[0] + x[1], x[2] * x[0]);
    };
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(layers.size());
    std::vector<double> volume(static_cast<std::size_t>(layers.size()), 0.0);
    std::vector<int> odd, even;
    for (const int e : sample::all_elements(mesh)) (e % 2 == 0 ? even : odd).push_back(e);
    for (const auto& elements : {odd, even}) {
      const auto part = extract_part(mesh, "body", section, sample::steel, elements);
      sum += axial_stress_shares(part, layers) * sample::nodal(part.mesh, field);
      const auto shares = volume_shares(part, layers);
      for (std::size_t i = 0; i < volume.size(); ++i) volume[i] += shares[i];
    }
    const Eigen::VectorXd expected = axial_stress_shares(whole, layers) * sample::nodal(mesh, field);
    EXPECT_LT(sample::relative_error(sum, expected), 1e-12) << sample::name(model);
    EXPECT_THAT(volume, Each(DoubleNear(1.0, 1e-12))) << sample::name(model);
  }
}

}  // namespace
}  // namespace ricochet::fem
