#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "common/contact/compliance.hpp"
#include "common/contact/projection.hpp"

namespace ricochet::solver {

/// The linear equations of all pairs: rows of D x (PairRows). With a dense D the matrix of those rows that are not idle
/// is kept factored while they do not change; of more than a thousand, or with a D that is sparse or only multiplies,
/// BiCGSTAB (van der Vorst 1992) solves. Where that does not end with a small sparse D, its matrix is factored, too.
class PairSystem {
 public:
  /// `x`: forces to start from, and the solution; all normals, then all along t, then all along the binormal.
  void solve(const Compliance& compliance, const std::vector<PairRows>& rows, Eigen::VectorXd& x);

 private:
  void compute_factor(const Compliance& compliance, Eigen::Index directions);
  /// Returns whether that has led to the solution.
  bool solve_by_products(const Compliance& compliance, Eigen::Index directions, Eigen::VectorXd& x) const;

  std::vector<PairRows> rows_;
  bool factored_ = false;
  std::vector<Eigen::Index> involved_, place_;  ///< unknowns of the matrix; of every unknown its place there, or -1
  Eigen::MatrixXd matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd involved_rhs_, involved_force_;
};

}  // namespace ricochet::solver
