#pragma once

#include <Eigen/Core>
#include <vector>

#include "implicit_solver/contact/near_inverse.hpp"

namespace ricochet::implicit_solver {

/// A f as `product` gives it, A square, but of few forces as the sum of their columns of A, f_j times each, which
/// `product` gives once and which are kept: where a ball touches, a window asks for the same few dozens of times over.
/// Which of the two ways it is depends on f alone, not on what is kept, so that a run that goes on from a checkpoint
/// computes the same bits.
class KeptColumns {
 public:
  /// `product` is asked for more forces than `most_pushed`. At most `most_kept` columns are kept, no fewer than those.
  KeptColumns(SolveFor product, Eigen::Index most_pushed, Eigen::Index most_kept);
  /// Forces of another number than before are those of other rows: nothing is kept of these.
  void operator()(const Eigen::VectorXd& forces, Eigen::VectorXd& motion);

 private:
  void keep(Eigen::Index force);

  SolveFor product_;
  Eigen::Index most_pushed_, most_kept_;
  Eigen::MatrixXd columns_;  ///< the first `kept_` of them
  std::vector<int> column_;  ///< per force, -1: not kept
  std::vector<Eigen::Index> pushed_;
  Eigen::Index kept_ = 0;
  Eigen::VectorXd unit_, column_motion_;
};

}  // namespace ricochet::implicit_solver
