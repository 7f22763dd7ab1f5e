#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tests/common/fem/sample_elements.hpp"

namespace ricochet::fem {
namespace {

using sample::steel;

TEST(Elasticity, InvertsHookesLaw) {
  for (const Model model : {Model::plane_strain, Model::axisymmetric}) {
    const Eigen::Matrix4d d = elasticity(model, steel);
    const Eigen::Vector4d stress(120e6, -40e6, 75e6, 33e6);
    const double e = steel.youngs_modulus_pa, nu = steel.poisson_ratio;
    const Eigen::Vector4d strain((stress[0] - nu * (stress[1] + stress[2])) / e,
                                 (stress[1] - nu * (stress[0] + stress[2])) / e,
                                 (stress[2] - nu * (stress[0] + stress[1])) / e, 2.0 * (1.0 + nu) / e * stress[3]);
    EXPECT_LT((d * strain - stress).norm(), 1e-12 * stress.norm()) << sample::name(model);
  }
  EXPECT_EQ(elasticity(Model::bar, steel)(0, 0), 210e9);
}

TEST(PrincipalStresses, AreTheEigenvaluesOfTheStressTensor) {
  // Order of a stress: the shear couples the first two axes, in both plane models.
  const std::vector<Eigen::Vector4d> cases = {
      {1.0, 2.0, 3.0, 0.5}, {-5.0, 4.0, 0.1, -7.0}, {2.0, 2.0, 2.0, 0.0}, {1.0, -1.0, -9.0, 3.0}, {0.0, 0.0, 8.0, 1.0}};
  for (const Model model : {Model::plane_strain, Model::axisymmetric}) {
    for (const Eigen::Vector4d& s : cases) {
      Eigen::Matrix3d tensor;
      tensor << s[0], s[3], 0.0, s[3], s[1], 0.0, 0.0, 0.0, s[2];
      const Eigen::Vector3d expected = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor).eigenvalues().reverse();
      EXPECT_LT((principal_stresses(model, s) - expected).norm(), 1e-13 * (1.0 + expected.norm()));
    }
  }
}

TEST(PrincipalStresses, OfABarHoldTwoZeros) {
  EXPECT_EQ(principal_stresses(Model::bar, StressVector::Constant(1, 5.0)), Eigen::Vector3d(5.0, 0.0, 0.0));
  EXPECT_EQ(principal_stresses(Model::bar, StressVector::Constant(1, -5.0)), Eigen::Vector3d(0.0, 0.0, -5.0));
}

StressVector stress_of(std::initializer_list<double> values) {
  StressVector stress(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), stress.begin());
  return stress;
}

TEST(VonMisesStress, OfKnownStates) {
  for (const Model model : {Model::plane_strain, Model::axisymmetric}) {
    EXPECT_DOUBLE_EQ(von_mises_stress(model, stress_of({-7, 0, 0, 0})), 7) << "uniaxial";
    EXPECT_DOUBLE_EQ(von_mises_stress(model, stress_of({0, 0, 7, 0})), 7);
    EXPECT_DOUBLE_EQ(von_mises_stress(model, stress_of({5, 5, 5, 0})), 0) << "pressure";
    EXPECT_DOUBLE_EQ(von_mises_stress(model, stress_of({0, 0, 0, -2})), std::sqrt(12.0)) << "shear";
  }
  EXPECT_EQ(von_mises_stress(Model::bar, stress_of({-7})), 7);
}

TEST(VonMisesStress, IsThatOfThePrincipalStresses) {
  const StressVector stress = stress_of({1, -4, 2.5, 3, -0.5, 6});
  const Eigen::Vector3d p = principal_stresses(Model::solid, stress);
  const double expected =
      std::sqrt(0.5 * (std::pow(p[0] - p[1], 2) + std::pow(p[1] - p[2], 2) + std::pow(p[2] - p[0], 2)));
  EXPECT_NEAR(von_mises_stress(Model::solid, stress), expected, 1e-13 * expected);
}

TEST(WaveSpeeds, FollowTheElasticConstants) {
  const double lambda = elasticity(Model::plane_strain, steel)(0, 1);
  const double mu = elasticity(Model::plane_strain, steel)(3, 3);
  EXPECT_NEAR(longitudinal_wave_speed(Model::axisymmetric, steel), std::sqrt((lambda + 2.0 * mu) / 7850.0), 1e-9);
  EXPECT_NEAR(longitudinal_wave_speed(Model::bar, steel), std::sqrt(210e9 / 7850.0), 1e-9);
  EXPECT_NEAR(shear_wave_speed(steel), std::sqrt(mu / 7850.0), 1e-9);
}

}  // namespace
}  // namespace ricochet::fem
