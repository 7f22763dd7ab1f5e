#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/fem/part.hpp"
#include "implicit_solver/elimination_order.hpp"

namespace ricochet::implicit_solver {

/// A symmetric positive definite operator A (here M + dt^2/4 K), factored once as L D L^T by CHOLMOD with the *root*
/// unknowns ordered last (constrained minimum degree), so that one solve splits into
///   forward(b)   eliminate everything but the root: leaves the condensed right-hand side z of S x_root = z
///   root         the small dense problem S x_root = z + (forces found there), S the Schur complement on the root
///   backward(x)  recover everything else from x_root.
/// Contact forces act on root unknowns only, so contact states never touch the factor.
class CondensedFactor {
 public:
  /// `active`: unknowns kept (the others are constrained; their rows and columns are dropped); `root`: dofs of the
  /// root, all active. Throws SolverError if A is not positive definite.
  CondensedFactor(const fem::SparseMatrix& a, const std::vector<bool>& active, const std::vector<int>& root);

  /// Loads b (full length, inactive entries ignored) and eliminates; afterwards root_rhs() holds z.
  void forward(const Eigen::VectorXd& b);
  [[nodiscard]] const Eigen::VectorXd& root_rhs() const { return root_rhs_; }
  /// S^-1, dense, symmetric, in the order of `root`.
  [[nodiscard]] const Eigen::MatrixXd& root_inverse() const { return root_inverse_; }
  /// Completes the solve of the last `forward`, as often as wanted, given x_root = S^-1 (z + ...); writes all active
  /// entries of x (inactive ones untouched).
  void backward(const Eigen::VectorXd& x_root, Eigen::VectorXd& x);

  [[nodiscard]] std::size_t factor_entries() const { return values_.size(); }

 private:
  /// Neighbouring columns of L whose structures are the same but for themselves, dense: a strictly lower triangle
  /// (width x width, column-major), then a rectangle (rows x width, column-major).
  struct Block {
    int first, width;     ///< columns first .. first + width - 1
    int rows, first_row;  ///< rows below, row_[first_row ...]
    std::size_t values;   ///< values_[values ...]
  };
  void collect_blocks(const std::vector<ColumnRange>& ranges, const int* start, const int* rows, const double* values);

  int interior_ = 0;           ///< unknowns eliminated before the root
  std::vector<int> dof_of_;    ///< factor order -> dof
  std::vector<Block> blocks_;  ///< of the interior
  std::vector<int> row_;
  std::vector<double> values_, inverse_diagonal_;
  int largest_block_ = 0;
  Eigen::VectorXd gathered_;  ///< what a block's rows hold
  Eigen::VectorXd work_, solution_, root_rhs_;
  Eigen::MatrixXd root_inverse_;
};

}  // namespace ricochet::implicit_solver
