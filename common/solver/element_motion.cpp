#include "common/solver/element_motion.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ricochet::solver {

double smallest_jacobian_ratio(const fem::ElementGeometry& element, const Displacements& u) {
  const auto& kind = fem::traits(element.kind);
  fem::ElementCoordinates moved = element.x;
  for (Eigen::Index i = 0; i < moved.rows(); ++i) {
    for (Eigen::Index c = 0; c < moved.cols(); ++c) moved(i, c) += u[static_cast<std::size_t>(i)][c];
  }
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& corner : kind.corner)
    smallest = std::min(smallest, kind.jacobian(moved, corner) / kind.jacobian(element.x, corner));
  return smallest;
}

double principal_strain(const Eigen::Matrix2d& gradient) {
  const double mean = 0.5 * (gradient(0, 0) + gradient(1, 1)), difference = 0.5 * (gradient(0, 0) - gradient(1, 1));
  return std::abs(mean) + std::hypot(difference, 0.5 * (gradient(0, 1) + gradient(1, 0)));
}

double principal_strain(const Eigen::Matrix3d& gradient) {
  const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(strain, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .cwiseAbs()
      .maxCoeff();
}

double rotation_angle(const Eigen::Matrix2d& gradient) {
  return std::abs(std::atan2(gradient(1, 0) - gradient(0, 1), 2.0 + gradient.trace()));
}

double rotation_angle(const Eigen::Matrix3d& gradient) {
  const Eigen::Vector3d axial(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0),
                              gradient(1, 0) - gradient(0, 1));
  return std::atan2(axial.norm(), 2.0 + gradient.trace());
}

double hoop_strain(const fem::Mesh& mesh, const fem::Element& nodes, const Displacements& u) {
  double u_r = 0.0, r = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    u_r += u[i][0];
    r += mesh.position[static_cast<std::size_t>(nodes[i])][0];
  }
  return u_r / r;
}

Eigen::Matrix3d inverse_diagonals(const fem::ElementGeometry& geometry) {
  const fem::ElementTraits& kind = fem::traits(geometry.kind);
  Eigen::Matrix3d diagonals = Eigen::Matrix3d::Identity();
  Eigen::Index column = 0;
  for (const auto& [a, b] : kind.diagonals) {
    for (Eigen::Index c = 0; c < geometry.x.cols(); ++c) diagonals(c, column) = geometry.x(b, c) - geometry.x(a, c);
    ++column;
  }
  if (kind.dimension == 3) return diagonals.inverse();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  const Eigen::Matrix2d plane = diagonals.topLeftCorner<2, 2>();
  inverse.topLeftCorner<2, 2>() = plane.inverse();
  return inverse;
}

}  // namespace ricochet::solver
