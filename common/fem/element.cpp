#include "common/fem/element.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ricochet::fem {

ElementCoordinates matrix_places(Model model, const ElementGeometry& element) {
  ElementCoordinates x = element.x;
  if (model == Model::bar) return x;
  for (Eigen::Index c = model == Model::axisymmetric ? 1 : 0; c < x.cols(); ++c) {
    const double first = x(0, c);
    for (Eigen::Index i = 0; i < x.rows(); ++i) x(i, c) -= first;
  }
  double size = 0.0;
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    for (Eigen::Index i = 0; i < x.rows(); ++i) size = std::max(size, std::abs(x(i, c) - x(0, c)));
  const double grain = std::ldexp(1.0, std::ilogb(size) - 36);
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    for (Eigen::Index i = 0; i < x.rows(); ++i) x(i, c) = grain * std::round(x(i, c) / grain);
  return x;
}

ElementMatrix element_stiffness(const Section& section, const Material& material, const ElementGeometry& element) {
  return traits(element.kind).stiffness(section, material, matrix_places(section.model, element));
}

Eigen::VectorXd element_volume(const Section& section, const ElementGeometry& element) {
  return traits(element.kind).volume(section, element.x);
}

Eigen::VectorXd element_lumped_mass(const Section& section, const Material& material, const ElementGeometry& element) {
  // The shape functions sum to one, so the row sum of rho * integral of N_i N_j dV is rho * integral of N_i dV.
  return material.density_kg_m3 * element_volume(section, element);
}

StressVector element_stress(const Section& section, const Material& material, const ElementGeometry& element,
                            const ElementVector& u, const NaturalPoint& at) {
  return traits(element.kind).stress(section, material, matrix_places(section.model, element), u, at);
}

std::vector<ElementPoint> element_points(const Section& section, const ElementGeometry& element) {
  return traits(element.kind).points(section, matrix_places(section.model, element));
}

EdgeLengths edge_lengths(const ElementGeometry& element) {
  EdgeLengths lengths{std::numeric_limits<double>::infinity(), 0.0};
  for (const auto& [a, b] : traits(element.kind).edges) {
    const double length = (element.x.row(b) - element.x.row(a)).norm();
    lengths = {std::min(lengths.shortest, length), std::max(lengths.longest, length)};
  }
  return lengths;
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
ElementMatrix mass_scaled_stiffness(const Section& section, const Material& material, const ElementGeometry& element) {
  const int dofs_per_node = components(section.model);
  const Eigen::VectorXd mass = element_lumped_mass(section, material, element);
  ElementMatrix scaled = element_stiffness(section, material, element);
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

double element_max_frequency_squared(const Section& section, const Material& material, const ElementGeometry& element) {
  return largest_eigenvalue(mass_scaled_stiffness(section, material, element));
}

bool element_frequency_squared_above(const Section& section, const Material& material, const ElementGeometry& element,
                                     double limit) {
  const ElementMatrix scaled = mass_scaled_stiffness(section, material, element);
  if (scaled.diagonal().maxCoeff() > limit) return true;
  if (scaled.cwiseAbs().rowwise().sum().maxCoeff() < limit) return false;
  return largest_eigenvalue(scaled) > limit;
}

}  // namespace ricochet::fem
