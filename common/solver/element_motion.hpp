#pragma once

#include <Eigen/Core>
#include <array>

#include "common/fem/part.hpp"

/// What the watch on the model asks of an element that has moved. H: displacement gradient.
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

}  // namespace ricochet::solver
