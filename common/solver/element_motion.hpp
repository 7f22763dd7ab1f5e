#pragma once

#include <Eigen/Core>
#include <array>

#include "common/fem/part.hpp"

/// The numbers that the watch on the model asks of an element that has moved. H: displacement gradient.
namespace ricochet::solver {

using Displacements = std::array<Eigen::Vector3d, fem::Element::most_nodes>;  ///< of an element's nodes [m]

/// Smallest Jacobian at a corner of a moved element over that of the reference.
[[nodiscard]] double smallest_jacobian_ratio(const fem::ElementGeometry& element, const Displacements& u);

/// Largest |principal value| of the symmetric part of H.
[[nodiscard]] double principal_strain(const Eigen::Matrix2d& gradient);
[[nodiscard]] double principal_strain(const Eigen::Matrix3d& gradient);

/// Exact for a rotation of any angle theta, whose H has 2 sin(theta) in its antisymmetric part and a trace of
/// 2 cos(theta) - 2, in three dimensions, too [rad].
[[nodiscard]] double rotation_angle(const Eigen::Matrix2d& gradient);
[[nodiscard]] double rotation_angle(const Eigen::Matrix3d& gradient);

/// u_r / r at an element's middle.
[[nodiscard]] double hoop_strain(const fem::Mesh& mesh, const fem::Element& nodes, const Displacements& u);

/// The inverse of the differences of places (of the kind's diagonals) whose differences of displacement give H.
[[nodiscard]] Eigen::Matrix3d inverse_diagonals(const fem::ElementGeometry& geometry);

/// The differences whose ratio, of displacements to places, is H in an element's middle, as its stress there has it
/// (fem::element_stress): its diagonals, and of a hexahedron the mean edges along its natural directions.
template <int dimension>
[[nodiscard]] Eigen::Matrix<double, dimension, dimension> middle_differences(fem::ElementKind kind,
                                                                             const Displacements& of_nodes) {
  Eigen::Matrix<double, dimension, dimension> differences;
  if (kind == fem::ElementKind::hexahedron) {
    const Eigen::Matrix<double, dimension, 1> p = (of_nodes[6] - of_nodes[0]).template head<dimension>(),
                                              q = (of_nodes[7] - of_nodes[1]).template head<dimension>(),
                                              r = (of_nodes[4] - of_nodes[2]).template head<dimension>(),
                                              s = (of_nodes[5] - of_nodes[3]).template head<dimension>();
    differences.col(0) = p - q - r + s;
    differences.col(1) = p + q - r - s;
    differences.col(dimension - 1) = p + q + r + s;
    return differences;
  }
  const auto diagonals = fem::traits(kind).diagonals;
  for (int c = 0; c < dimension; ++c) {
    const auto& [from, to] = diagonals[fem::at(c)];
    differences.col(c) = (of_nodes[fem::at(to)] - of_nodes[fem::at(from)]).template head<dimension>();
  }
  return differences;
}

}  // namespace ricochet::solver
