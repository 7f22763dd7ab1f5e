// The effects of contact forces over a window: work, impulses, and the energy that massless nodes give back.
#include <algorithm>
#include <cmath>

#include "explicit_solver/explicit_contact.hpp"

namespace ricochet::explicit_solver {

using solver::BodyState;
using solver::ContactRow;
using solver::ContactState;
using solver::Pair;

/// The work of the contact forces over the window that ended, inside the small steps.
double ExplicitContact::work_inside(const std::vector<BodyState>& states,
                                    const std::vector<const Eigen::VectorXd*>& u_before) const {
  double work = 0.0;
  for (std::size_t b = 0; b < states.size(); ++b)
    work += 0.5 * (old_spread_[b] + spread_[b]).dot(states[b].u - *u_before[b]);
  return work;
}

double ExplicitContact::account(const Pair& pair, const Force& mean, std::vector<BodyState>& states,
                                const std::vector<const Eigen::VectorXd*>& u_before) {
  const auto moved = [&](const ContactRow& row) {
    return row.times(displacement_of(states)) - row.times(before_of(u_before));
  };
  const double made = mean.normal * moved(pair.normal);
  if (!inside_small_steps()) state_.work_normal_j += made;
  double taken = mean.tangential[0] * moved(pair.tangent);
  if (surface_.components == 3) taken += mean.tangential[1] * moved(pair.binormal);
  state_.dissipated_friction_j -= taken;
  const auto middle = [&](int part, int dof) {
    const auto p = static_cast<std::size_t>(part);
    return 0.5 * (states[p].u[dof] + (*u_before[p])[dof]);
  };
  const auto moved_of = [&](int part, int dof) {
    const auto p = static_cast<std::size_t>(part);
    return states[p].u[dof] - (*u_before[p])[dof];
  };
  solver::book_impulse(pair, dt() * mean.normal, dt() * mean.tangential, middle, states, state_.impulses);
  solver::book_given_motion(pair, mean.normal, mean.tangential, moved_of, states);
  return made;
}

/// After the normal impulse of the window has changed: the friction impulse stays within its cone and, of a slipping
/// pair that this does not turn around, on it. It keeps its direction e.
void ExplicitContact::clip_friction(std::size_t i, std::vector<BodyState>& states) {
  const auto& pair = surface_.pairs[i];
  Eigen::Vector2d& force = state_.mean_forces[i].tangential;
  const double mean = std::hypot(force[0], force[1]);
  if (mean == 0.0) return;
  const Eigen::Vector2d e = force / mean;
  const double limit = pair.friction_coefficient * state_.mean_forces[i].normal,
               inverse = e.dot(pair.inverse_mass_along(states) * e);
  const double target = state_.mean_forces[i].state == ContactState::slip ? limit : std::min(mean, limit);
  if (target == mean || inverse == 0.0) return;
  const double rate = e.dot(pair.slip(velocity_of(states)));
  double impulse = dt() * (target - mean);
  if (target > mean && (rate + inverse * impulse) * rate < 0.0) impulse = -rate / inverse;
  const auto velocities = [&states](int part) -> Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].v; };
  pair.push_along(impulse * e, states, velocities);
  state_.dissipated_friction_j -= impulse * (rate + 0.5 * impulse * inverse);
  solver::book_impulse(pair, 0.0, impulse * e, solver::displacement_at(states), states, state_.impulses);
  force += impulse / dt() * e;
}

void ExplicitContact::finish(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  if (!massless_) return;
  massless_->for_each_dof(
      [&](std::size_t part, int dof) { states[part].v[dof] = (states[part].u[dof] - (*u_before[part])[dof]) / dt(); });
  massless_->begin_trial();
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const double impulse = massless_->give_back(i, made_j_[i], dt() * state_.mean_forces[i].normal, states,
                                                [&](std::size_t part) { return states[part].v.data(); });
    state_.mean_forces[i].normal += impulse / dt();
    solver::book_impulse(surface_.pairs[i], impulse, Eigen::Vector2d::Zero(), solver::displacement_at(states), states,
                         state_.impulses);
    clip_friction(i, states);
  }
  state_.work_normal_j += massless_->trial_work_j();
  massless_->accept();
}

/// dt^2/8 a^T M a of a pair's nodes: what the staggered metric takes off 1/2 v^T M v. A contact force at n = 0 changes
/// it at once; that change is the energy an impact at the start costs.
double ExplicitContact::staggered_correction(const Pair& pair, const std::vector<BodyState>& states) const {
  double sum = 0.0;
  const auto has = [](const ContactRow& row, const solver::RowEntry& e) {
    return std::any_of(row.entries.begin(), row.entries.end(),
                       [&](const auto& n) { return n.part == e.part && n.dof == e.dof; });
  };
  for (const auto* row : {&pair.normal, &pair.tangent, &pair.binormal}) {
    for (const auto& e : row->entries) {
      const bool counted = (row != &pair.normal && has(pair.normal, e)) ||  // where n is along no coordinate
                           (row == &pair.binormal && has(pair.tangent, e));
      const auto& state = states[static_cast<std::size_t>(e.part)];
      if (!counted) sum += 0.125 * dt() * dt() * state.mass[e.dof] * state.a[e.dof] * state.a[e.dof];
    }
  }
  return sum;
}

/// The sum over all nodes.
double ExplicitContact::staggered_correction(const std::vector<BodyState>& states) const {
  double sum = 0.0;
  for (const auto& state : states) sum += 0.125 * dt() * dt() * state.a.dot(state.mass.cwiseProduct(state.a));
  return sum;
}

}  // namespace ricochet::explicit_solver
