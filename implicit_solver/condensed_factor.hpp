#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/base/parallel.hpp"
#include "common/fem/part.hpp"
#include "common/participant/heartbeat.hpp"
#include "implicit_solver/elimination_order.hpp"
#include "implicit_solver/subtrees.hpp"

namespace ricochet::implicit_solver {

class Supernodes;

/// A symmetric positive definite operator A (here M + dt^2/4 K), factored once as L D L^T by CHOLMOD with the *root*
/// unknowns ordered last (constrained minimum degree), so that one solve splits into
///   forward(b)   eliminate everything but the root: leaves the condensed right-hand side z of S x_root = z
///   root         the small dense problem S x_root = z + (forces found there), S the Schur complement on the root
///   backward(x)  recover everything else from x_root.
/// Contact forces act on root unknowns only, so contact states never touch the factor.
///
/// Threads take Subtrees, and of the wide blocks above them some rows or columns each. All sums are made in one order:
/// the same bits for any number of threads.
class CondensedFactor {
 public:
  /// `active`: unknowns kept (the others are constrained; their rows and columns are dropped); `root`: dofs of the
  /// root, all active; `parallel`: the threads to compute with (null: the caller alone). Throws SolverError if A is not
  /// positive definite.
  CondensedFactor(fem::SparseMatrix a, const std::vector<bool>& active, const std::vector<int>& root,
                  std::shared_ptr<Parallel> parallel = nullptr, participant::Heartbeat* heart = nullptr);

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
  void collect_blocks(const std::vector<ColumnRange>& ranges, const Supernodes& factor);
  void collect_targets();
  void invert_root(int roots, const Supernodes& factor);
  template <class Work>
  void for_each(int parts, const Work& work);
  [[nodiscard]] int parts_of(const Block& block) const;
  void load(const Eigen::VectorXd& b, int first, int end);
  void eliminate(const Block& block, int first, int end, const double* own, double* of_rows);
  void add_from_subtrees();
  void gather(const Block& block, double* y) const;
  void recover(const Block& block, int first, int end, const double* y, int thread);
  void store(int first, int end, Eigen::VectorXd& x) const;

  std::shared_ptr<Parallel> parallel_;
  int interior_ = 0;           ///< unknowns eliminated before the root
  std::vector<int> dof_of_;    ///< factor order -> dof
  std::vector<Block> blocks_;  ///< of the interior
  std::vector<int> row_;
  /// Where `forward` subtracts what belongs into row_: there, but for rows outside of a block's subtree. The numbers to
  /// be added to those are collected behind the unknowns of work_, subtree by subtree: in the order of the rows of the
  /// subtree's last block, which has all of them.
  std::vector<int> target_;
  /// For a block with the columns (T over R) of L, T the unit lower triangle of its own rows: (T^-1 over -R T^-1), in
  /// panels, so that a block is one product in `forward`, and one by the transpose in `backward`.
  std::vector<double> values_;
  std::vector<double> inverse_diagonal_;
  Subtrees division_;
  Eigen::MatrixXd of_rows_, sums_;  ///< per thread: a value a row of a block; four a column
  Eigen::VectorXd own_;             ///< unknowns of a block that threads share
  Eigen::VectorXd work_, solution_, root_rhs_;
  Eigen::MatrixXd root_inverse_;
};

}  // namespace ricochet::implicit_solver
