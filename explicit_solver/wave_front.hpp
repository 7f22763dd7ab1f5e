#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/archive.hpp"
#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::explicit_solver {

/// The rows of a part that a wave can have reached; in all others K u is exactly zero and is not computed.
///
/// A node that no force has ever acted on has the velocity it began with, and a row takes displacements relative to its
/// own node (StiffnessProduct): where a row and its neighbours began alike and none of them has felt a force, all of
/// them have moved by the same bits, and K u there is 0.0, not nearly so. Rows are kept by the slices of the product. A
/// slice is *reached* once K u in it has not been zero, and from the start where anything else may move it; the
/// neighbours of a reached slice are computed, too, and looked at after every product. No slice ever falls back, so
/// that trial windows that are given up leave no more than some rows too many.
class WaveFront {
 public:
  WaveFront() = default;
  /// `state` before the first window. Reached at once: `driven` nodes, which the interface or a contact moves, loads,
  /// prescribed motion, and rows whose neighbours do not begin with the same displacement and velocity. Rows that read
  /// nodes of other ranks are always computed, since a wave may come from there.
  WaveFront(const solver::BodyState& state, const std::vector<int>& driven);

  using Rows = solver::Rows;
  /// The rows to compute, ascending, none touching the next; all others have no force and no acceleration.
  [[nodiscard]] const std::vector<Rows>& rows() const { return rows_; }

  /// force = K u [N] of the part in these rows; the others are left alone. In a share of a part `u` of other ranks'
  /// nodes is written: it comes in while rows are computed that do not read it.
  void multiply(const solver::BodyState& state, Eigen::VectorXd& u, Eigen::VectorXd& force) const;
  /// Moves the front on to the neighbours of the rows where K u has become other than zero.
  void grow(const Eigen::VectorXd& force);
  /// From here on every row is computed: the motion is no longer what the part began with.
  void reach_all();
  /// How far it has come.
  void archive(Archive& a);

 private:
  enum class Reach : unsigned char { none, next, reached };
  void set_neighbours(const solver::BodyState& state, int slices);
  void reach(int slice);
  void look_at(int slice);
  void collect_rows();

  int size_ = 0, slice_ = 1;                      ///< rows of the part, of a slice
  std::vector<int> neighbour_start_, neighbour_;  ///< slices with an entry in the rows of slice s, s itself included
  std::vector<Reach> reach_;                      ///< per slice
  std::vector<int> front_, next_front_;           ///< slices that are computed, but not reached
  std::vector<bool> outer_;                       ///< per slice: it reads nodes of other ranks
  std::vector<Rows> rows_, inner_rows_, outer_rows_;
};

}  // namespace ricochet::explicit_solver
