#include "common/fem/element.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "common/fem/bar.hpp"
#include "common/fem/quadrilateral.hpp"

namespace ricochet::fem {

ElementMatrix element_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  return section.model == Model::bar ? bar_stiffness(section, material, x)
                                     : quadrilateral_stiffness(section, material, x);
}

Eigen::VectorXd element_volume(const Section& section, const ElementCoordinates& x) {
  return section.model == Model::bar ? bar_volume(section, x) : quadrilateral_volume(section, x);
}

Eigen::VectorXd element_lumped_mass(const Section& section, const Material& material, const ElementCoordinates& x) {
  // The shape functions sum to one, so the row sum of rho * integral of N_i N_j dV is rho * integral of N_i dV.
  return material.density_kg_m3 * element_volume(section, x);
}

StressVector element_stress(const Section& section, const Material& material, const ElementCoordinates& x,
                            const ElementVector& u, double xi, double eta) {
  return section.model == Model::bar ? bar_stress(material, x, u)
                                     : quadrilateral_stress(section, material, x, u, xi, eta);
}

Eigen::Vector2d edge_area(const Section& section, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  if (section.model == Model::bar) return {section.measure, 0.0};
  const double half = 0.5 * section.measure * (b - a).norm();
  if (section.model == Model::plane_strain) return {half, half};
  // integral of N r ds along a straight edge, r linear
  return {half * (2.0 * a[0] + b[0]) / 3.0, half * (a[0] + 2.0 * b[0]) / 3.0};
}

namespace {

/// M_e^-1/2 K_e M_e^-1/2, symmetric.
ElementMatrix mass_scaled_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  const int dofs_per_node = components(section.model);
  const Eigen::VectorXd mass = element_lumped_mass(section, material, x);
  ElementMatrix scaled = element_stiffness(section, material, x);
  for (Eigen::Index i = 0; i < scaled.rows(); ++i) {
    for (Eigen::Index j = 0; j < scaled.cols(); ++j) {
      scaled(i, j) /= std::sqrt(mass[i / dofs_per_node] * mass[j / dofs_per_node]);
    }
  }
  return scaled;
}

double largest_eigenvalue(const ElementMatrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<ElementMatrix> solver(symmetric, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[symmetric.rows() - 1];  // they ascend
}

}  // namespace

double element_max_frequency_squared(const Section& section, const Material& material, const ElementCoordinates& x) {
  return largest_eigenvalue(mass_scaled_stiffness(section, material, x));
}

bool element_frequency_squared_above(const Section& section, const Material& material, const ElementCoordinates& x,
                                     double limit) {
  const ElementMatrix scaled = mass_scaled_stiffness(section, material, x);
  if (scaled.diagonal().maxCoeff() > limit) return true;
  if (scaled.cwiseAbs().rowwise().sum().maxCoeff() < limit) return false;
  return largest_eigenvalue(scaled) > limit;
}

}  // namespace ricochet::fem
