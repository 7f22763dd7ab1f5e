#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>

#include "common/fem/element.hpp"

namespace ricochet::fem {

Eigen::MatrixXd elasticity(Model model, const Material& material) {
  const double young = material.youngs_modulus_pa;
  const double nu = material.poisson_ratio;
  if (model == Model::bar) return Eigen::MatrixXd::Constant(1, 1, young);
  const double lambda = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double mu = young / (2.0 * (1.0 + nu));
  const int size = stress_components(model);  // three direct strains, then shear
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(size, size);
  d.topLeftCorner<3, 3>().setConstant(lambda);
  d.diagonal().head<3>().setConstant(lambda + 2.0 * mu);
  d.diagonal().tail(size - 3).setConstant(mu);
  return d;
}

namespace {

Eigen::Vector3d principal_stresses_of_solid(const StressVector& stress) {
  Eigen::Matrix3d tensor;
  tensor << stress[0], stress[3], stress[5], stress[3], stress[1], stress[4], stress[5], stress[4], stress[2];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(tensor, Eigen::EigenvaluesOnly);  // in closed form: it is asked for in every window
  return solver.eigenvalues().reverse();
}

}  // namespace

StressVector turned(const StressVector& tensor, const Eigen::Matrix3d& rotation) {
  constexpr int first[3] = {0, 1, 0}, second[3] = {1, 2, 2};
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  for (Eigen::Index c = 0; c < 3; ++c) matrix(c, c) = tensor[c];
  for (Eigen::Index shear = 3; shear < tensor.size(); ++shear)
    matrix(first[shear - 3], second[shear - 3]) = matrix(second[shear - 3], first[shear - 3]) = tensor[shear];
  matrix = (rotation * matrix * rotation.transpose()).eval();
  StressVector result = tensor;
  for (Eigen::Index c = 0; c < 3; ++c) result[c] = matrix(c, c);
  for (Eigen::Index shear = 3; shear < tensor.size(); ++shear)
    result[shear] = matrix(first[shear - 3], second[shear - 3]);
  return result;
}

Eigen::Vector3d principal_stresses(Model model, const StressVector& stress) {
  if (model == Model::solid) return principal_stresses_of_solid(stress);
  Eigen::Vector3d principal(stress[0], 0.0, 0.0);
  if (model != Model::bar) {
    // In both plane models the third axis is principal and the shear couples the first two.
    const double mean = 0.5 * (stress[0] + stress[1]);
    const double radius = std::hypot(0.5 * (stress[0] - stress[1]), stress[3]);
    principal << mean + radius, mean - radius, stress[2];
  }
  std::sort(principal.data(), principal.data() + 3, std::greater<>());
  return principal;
}

double von_mises_stress(Model model, const StressVector& stress) {
  if (model == Model::bar) return std::abs(stress[0]);
  const double a = stress[0] - stress[1], b = stress[1] - stress[2], c = stress[2] - stress[0];
  const double shear = stress.tail(stress.size() - 3).squaredNorm();
  return std::sqrt(0.5 * (a * a + b * b + c * c) + 3.0 * shear);
}

double longitudinal_wave_speed(Model model, const Material& material) {
  const double young = material.youngs_modulus_pa;
  const double nu = material.poisson_ratio;
  const double rho = material.density_kg_m3;
  if (model == Model::bar) return std::sqrt(young / rho);
  return std::sqrt(young * (1.0 - nu) / (rho * (1.0 + nu) * (1.0 - 2.0 * nu)));
}

double shear_wave_speed(const Material& material) {
  return std::sqrt(material.youngs_modulus_pa / (2.0 * material.density_kg_m3 * (1.0 + material.poisson_ratio)));
}

}  // namespace ricochet::fem
