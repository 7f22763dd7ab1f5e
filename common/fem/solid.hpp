#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include "common/fem/element.hpp"

/// Integrals of solid isoparametric elements, strains (xx, yy, zz, xy, yz, zx). `Shape` is a kind's shape functions and
/// quadrature:
///   nodes                             how many
///   at(p)                             N_i at a natural point, a vector
///   natural_gradient(p)               N_i,xi N_i,eta N_i,zeta, a row per node
///   points                            quadrature points and weights
/// Code that looks longer than it need be is written so that GCC 12 raises no false alarm in its own AVX-512 headers.
namespace ricochet::fem {

using Voigt = Eigen::Matrix<double, 6, 1>;

struct SolidPoint {
  double xi, eta, zeta, weight;
  [[nodiscard]] NaturalPoint natural() const { return {xi, eta, zeta}; }
};

template <class Shape>
struct Solid {
  static constexpr int nodes = Shape::nodes;
  using Coordinates = Eigen::Matrix<double, nodes, 3>;
  using StrainOperator = Eigen::Matrix<double, 6, 3 * nodes>;

  /// The columns that elements of this kind have of ElementCoordinates.
  static Coordinates places(const ElementCoordinates& x) {
    Coordinates places;
    for (int i = 0; i < 3 * nodes; ++i) places(i / 3, i % 3) = x(i / 3, i % 3);
    return places;
  }

  /// Strains of displacements N_i with these gradients, a row per function.
  template <class Gradient>
  static auto strains(const Gradient& gradient) {
    constexpr int functions = Gradient::RowsAtCompileTime;
    Eigen::Matrix<double, 6, 3 * functions> b;
    b.setZero();
    for (int i = 0; i < functions; ++i) {
      const double dx = gradient(i, 0), dy = gradient(i, 1), dz = gradient(i, 2);
      b(0, 3 * i) = b(3, 3 * i + 1) = b(5, 3 * i + 2) = dx;
      b(1, 3 * i + 1) = b(3, 3 * i) = b(4, 3 * i + 2) = dy;
      b(2, 3 * i + 2) = b(4, 3 * i + 1) = b(5, 3 * i) = dz;
    }
    return b;
  }

  static Eigen::Matrix3d jacobian_matrix(const Coordinates& x, const NaturalPoint& at) {
    const Coordinates natural = Shape::natural_gradient(at);
    Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();  // J(a, c) = x_c,a
    for (int i = 0; i < nodes; ++i) jacobian += natural.row(i).transpose() * x.row(i);
    return jacobian;
  }

  static StrainOperator strain_operator(const Coordinates& x, const NaturalPoint& at) {
    const Coordinates gradient = Shape::natural_gradient(at) * jacobian_matrix(x, at).inverse().transpose();
    return strains(gradient);
  }

  /// integral of N_i dV.
  static Eigen::VectorXd volume(const Coordinates& x) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(nodes);
    for (const SolidPoint& q : Shape::points) {
      const Eigen::Matrix<double, nodes, 1> shape = Shape::at(q.natural());
      const double volume = q.weight * jacobian_matrix(x, q.natural()).determinant();
      for (int i = 0; i < nodes; ++i) sum[i] += volume * shape[i];
    }
    return sum;
  }

  static double jacobian(const ElementCoordinates& x, const NaturalPoint& at) {
    return jacobian_matrix(places(x), at).determinant();
  }
};

}  // namespace ricochet::fem
