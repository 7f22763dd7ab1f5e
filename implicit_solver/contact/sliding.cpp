// The part of ImplicitContact for bodies that slide along each other: rows that are written anew.
#include "implicit_solver/contact/implicit_contact.hpp"

namespace ricochet::implicit_solver {

using solver::BodyState;
using solver::ContactState;

/// Before a window is solved, for the middle of it: forces that act along the rows there, over all of it, keep the
/// angular momentum of bodies that slide freely.
bool ImplicitContact::follow(const std::vector<BodyState>& states) {
  if (!sliding_) return false;
  std::vector<solver::Pair> before = surface_.pairs;
  if (!sliding_->follow(states, 0.5 * dt_, 0.5 * dt_, state_.mean_forces, surface_.pairs)) return false;
  const std::vector<int> same = solver::same_pairs(before, surface_.pairs);
  if (before_.pairs.empty()) {  // else a window is tried again
    before_.pairs = std::move(before);
    before_.remembered = state_.remembered;
  }
  state_.remembered = solver::carried(same, state_.remembered);
  state_.mean_forces = solver::carried(same, state_.mean_forces);
  solver::RootProblem::Solution solution;
  solution.states = solver::carried(same, state_.solution.states, ContactState::open);
  const auto n = static_cast<Eigen::Index>(same.size()), old = static_cast<Eigen::Index>(state_.solution.states.size());
  solution.force.setZero(directions() * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index d = 0; d < directions() && same[static_cast<std::size_t>(i)] >= 0; ++d)
      solution.force[d * n + i] = state_.solution.force[d * old + same[static_cast<std::size_t>(i)]];
  }
  state_.solution = std::move(solution);
  take_new_pairs(states);
  return true;
}

/// Rows of long ago would tell gaps too late.
void ImplicitContact::fly(const std::vector<BodyState>& states) {
  if (follow(states)) open();
}

/// All that is sized by the pairs or computed from their rows, but what state_ keeps of them.
void ImplicitContact::take_new_pairs(const std::vector<BodyState>& states) {
  inverse_mass_.reset();
  write_rows();
  if (response_.product) {
    set_root({response_.product, bound_of_couplings(states)});
  } else {
    set_root(compliance_of_rows());
  }
}

}  // namespace ricochet::implicit_solver
