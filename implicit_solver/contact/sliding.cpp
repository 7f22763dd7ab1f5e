// The part of ImplicitContact for bodies that slide along each other: rows that are written anew.
#include "implicit_solver/contact/implicit_contact.hpp"

namespace ricochet::implicit_solver {

using solver::BodyState;
using solver::ContactState;

/// Before a window is solved, for the middle of it: forces that act along the rows there, over all of it, keep the
/// angular momentum of bodies that slide freely.
void ImplicitContact::follow(const std::vector<BodyState>& states) {
  if (!sliding_) return;
  std::vector<solver::Pair> before = surface_.pairs;
  if (!sliding_->follow(states, 0.5 * dt_, surface_.pairs)) return;
  const std::vector<int> same = solver::same_pairs(before, surface_.pairs);
  if (old_pairs_.empty()) {  // else a window is tried again
    old_pairs_ = std::move(before);
    old_remembered_ = state_.remembered;
  }
  state_.remembered = solver::carried(same, state_.remembered);
  state_.impulse = solver::carried(same, state_.impulse);
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
}

/// All that is sized by the pairs or computed from their rows, but what state_ keeps of them.
void ImplicitContact::take_new_pairs(const std::vector<BodyState>& states) {
  shared_ = solver::held_askew(surface_.pairs, states) || solver::share_nodes(surface_.pairs);
  find_weights(states);
  impulse_.assign(surface_.pairs.size(), {});
  remembered_ = jump_impulse_ = impulse_;
  if (product_) {
    set_root({product_, bound_of_couplings(states)});
  } else {
    set_root(compliance_of_rows());
  }
}

/// kappa dt^2/4 G S^-1 G^T, with the few entries that a row has.
solver::Compliance ImplicitContact::compliance_of_rows() const {
  if (near_inverse_.size() > 0) {
    const solver::Compliance::Sparse rows = gather();
    solver::Compliance::Sparse compliance = rows * near_inverse_ * solver::Compliance::Sparse(rows.transpose());
    compliance *= kappa() * 0.25 * dt_ * dt_;
    return compliance;
  }
  struct Entry {
    Eigen::Index root;
    double coefficient;
  };
  std::vector<std::vector<Entry>> rows;
  for (Eigen::Index d = 0; d < directions(); ++d) {
    for (const auto& pair : surface_.pairs) {
      auto& row = rows.emplace_back();
      for (const auto& e : row_of(pair, static_cast<Direction>(d)).entries) {
        const int root = root_of_dof_[static_cast<std::size_t>(combined(e))];
        if (root >= 0) row.push_back({root, e.coefficient});
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd compliance(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index i = 0; i <= j; ++i) {
      double sum = 0.0;
      for (const auto& e : rows[static_cast<std::size_t>(i)]) {
        for (const auto& f : rows[static_cast<std::size_t>(j)])
          sum += e.coefficient * f.coefficient * root_inverse_(e.root, f.root);
      }
      compliance(i, j) = compliance(j, i) = kappa() * 0.25 * dt_ * dt_ * sum;
    }
  }
  return compliance;
}

}  // namespace ricochet::implicit_solver
