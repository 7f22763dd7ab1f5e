#pragma once

#include <Eigen/CholmodSupport>
#include <Eigen/Core>
#include <vector>

#include "common/fem/part.hpp"

namespace ricochet::explicit_solver {

/// The lowest modes of a body's part, K phi = omega^2 M phi with phi^T M phi = 1, those of rigid motion with them, and
/// the flexibility of all that are left out,
///   R = sum over the others of phi phi^T/omega^2  [m/N],
/// by which they follow a force at once. Modes by ARPACK (shift and invert), products with R by a Cholesky factor.
class LowestModes {
 public:
  /// `mass`: per degree of freedom, 0 where it is held [kg]; `count`: fewer than are free; `scale`: a frequency of the
  /// part as a whole, squared, such as (c/L)^2 [1/s^2]. SolverError if ARPACK does not converge or K is not positive
  /// semidefinite. The same input gives the same bits.
  LowestModes(const fem::SparseMatrix& stiffness, const Eigen::VectorXd& mass, int count, double scale);

  [[nodiscard]] Eigen::Index count() const { return omega_squared_.size(); }
  [[nodiscard]] const Eigen::VectorXd& omega_squared() const { return omega_squared_; }  ///< ascending [1/s^2]
  /// Degrees of freedom x modes, 0 where they are held [kg^-1/2].
  [[nodiscard]] const Eigen::MatrixXd& shapes() const { return shapes_; }
  /// M shapes [kg^1/2].
  [[nodiscard]] Eigen::MatrixXd momenta() const { return mass_.asDiagonal() * shapes_; }
  /// R f of forces in columns, to a relative error [m]; on what is held they do nothing.
  [[nodiscard]] Eigen::MatrixXd others(const Eigen::MatrixXd& forces, double error) const;

 private:
  using Factor = Eigen::CholmodDecomposition<Eigen::SparseMatrix<double>, Eigen::Lower>;
  void factor(double shift);
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& forces) const;
  void find(int count);

  Eigen::VectorXd mass_;
  std::vector<int> free_;                  ///< degrees of freedom
  Eigen::SparseMatrix<double> stiffness_;  ///< lower triangle, of what is free
  double shift_ = 0.0;                     ///< of the factor, K + shift M [1/s^2]
  Factor factor_;
  Eigen::VectorXd omega_squared_;
  Eigen::MatrixXd shapes_;
};

}  // namespace ricochet::explicit_solver
