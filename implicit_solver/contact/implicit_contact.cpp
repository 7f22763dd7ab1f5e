#include "implicit_solver/contact/implicit_contact.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace ricochet::implicit_solver {

using scene::Enforcement;
using scene::ImpactUpdate;
using scene::MultiplierUpdate;
using solver::BodyState;
using solver::ContactState;
using solver::Pair;
using solver::RowEntry;

ImplicitContact::ImplicitContact(const scene::Problem& problem, solver::ContactSurface surface,
                                 const std::vector<BodyState>& states)
    : problem_(&problem), surface_(std::move(surface)) {
  if (solver::SlidingRows sliding(problem, states); sliding.any()) sliding_ = std::move(sliding);
  int offset = 0;
  for (const auto& state : states) {
    offsets_.push_back(offset);
    offset += state.part.dofs();
    turns_ = turns_ || state.frame;
  }
  root_of_dof_.assign(static_cast<std::size_t>(offset), -1);
  // Normals that come may point anywhere where bodies turn or slide along what is not flat, however those of now do.
  const bool any_way = turns_ || (sliding_ && std::any_of(problem.contacts.begin(), problem.contacts.end(),
                                                          [](const auto& of) { return of.sliding && !of.flat; }));
  std::set<int> components;
  for (int c = 0; any_way && c < surface_.components; ++c) components.insert(c);
  for (const auto& pair : surface_.pairs) {
    std::vector<RowEntry> entries = pair.normal.entries;
    if (pair.friction_coefficient > 0.0) {
      entries.insert(entries.end(), pair.tangent.entries.begin(), pair.tangent.entries.end());
      entries.insert(entries.end(), pair.binormal.entries.begin(), pair.binormal.entries.end());
    }
    for (const auto& e : entries) components.insert(e.dof % surface_.components);
    for (std::size_t e = 0, size = entries.size(); any_way && e < size; ++e) {
      RowEntry beside = entries[e];
      const int first = beside.dof - beside.dof % surface_.components;
      for (beside.dof = first; beside.dof < first + surface_.components; ++beside.dof) entries.push_back(beside);
    }
    std::sort(entries.begin(), entries.end(),
              [](const RowEntry& x, const RowEntry& y) { return std::pair(x.side, x.dof) < std::pair(y.side, y.dof); });
    for (const auto& e : entries) add_root(e, states);
  }
  // Nodes that bodies slide to have a force in all these directions.
  for (const auto& [part, node] : surface_.idle)
    for (const int c : components) add_root({part, node * surface_.components + c}, states);
  trial_.start(pairs(), by_impedance());
  state_.mean_forces = state_.remembered = trial_.impulse;
  state_.uneven = trial_.uneven;
  state_.impulses = surface_.no_impulses();
  report_ = surface_.empty_record();
}

bool ImplicitContact::is_free(const RowEntry& e, const std::vector<BodyState>& states) {
  return states[static_cast<std::size_t>(e.part)].free[static_cast<std::size_t>(e.dof)];
}

void ImplicitContact::add_root(const RowEntry& e, const std::vector<BodyState>& states) {
  int& root = root_of_dof_[static_cast<std::size_t>(combined(e))];
  if (root >= 0 || !is_free(e, states)) return;
  root = static_cast<int>(root_dofs_.size());
  root_dofs_.push_back(combined(e));
}

void ImplicitContact::Trial::start(std::size_t pairs, bool uneven_too) {
  impulse.assign(pairs, {});
  jump = remembered = impulse;
  uneven_jump.assign(uneven_too ? pairs : 0, Eigen::Vector3d::Zero());
  uneven = uneven_jump;
  friction.assign(pairs, {});
}

double ImplicitContact::kappa() const {
  const bool fully_implicit =
      law().enforcement == Enforcement::multiplier && law().multiplier_update == MultiplierUpdate::fully_implicit;
  return fully_implicit ? 2.0 : 1.0;
}

bool ImplicitContact::massless() const { return law().multiplier_update == MultiplierUpdate::massless; }

bool ImplicitContact::by_impedance() const {
  return law().enforcement == Enforcement::penalty && law().impact_update == ImpactUpdate::impedance;
}

/// Whether the law sets velocities and accelerations of closed pairs.
bool ImplicitContact::resets() const {
  return remembered() && !(law().enforcement == Enforcement::penalty && law().impact_update == ImpactUpdate::none);
}

void ImplicitContact::move_masses(std::vector<BodyState>& states) {
  if (massless()) massless_.emplace(surface_, states);
}

void ImplicitContact::settle(const std::vector<BodyState>& states, const std::vector<Eigen::VectorXd>& external,
                             std::vector<Eigen::VectorXd>& u) {
  massless_->settle(
      states, [&](std::size_t part) -> const Eigen::VectorXd& { return external[part]; },
      [&](std::size_t part) -> Eigen::VectorXd& { return u[part]; });
}

void ImplicitContact::set_massless_velocity(const Eigen::VectorXd& increment, Eigen::VectorXd& velocity) const {
  massless_->for_each_dof([&](std::size_t part, int dof) {
    const int at = offsets_[part] + dof;
    velocity[at] = increment[at] / dt_;
  });
}

void ImplicitContact::start(solver::Compliance compliance) {
  const bool first = !root_;
  set_root(std::move(compliance));
  if (first) trial_.solution = state_.solution = root_->open();
}

void ImplicitContact::set_root(solver::Compliance compliance) {
  const auto n = static_cast<Eigen::Index>(pairs());
  std::vector<solver::RootProblem::PairLaw> own;
  for (const auto& pair : surface_.pairs) own.push_back({pair.area_m2, pair.friction_coefficient});
  root_.emplace(law(), std::move(compliance), own, dt_);
  free_.gap.setZero(n);
  free_.slip.setZero(2 * n);
  free_.slip_velocity.setZero(2 * n);
  root_force_.setZero(static_cast<Eigen::Index>(root_dofs_.size()));
}

/// Relative displacements at the end of the window without contact forces, from zero, of held pairs.
void ImplicitContact::find_moved(const std::vector<BodyState>& states, const Eigen::VectorXd& increment) {
  for (std::size_t i = 0; i < pairs(); ++i) {
    const auto& pair = surface_.pairs[i];
    free_.gap[unknown(i, 0)] = pair.normal.times(displacement_of(states)) + pair.normal.times(of_part(increment));
    const Eigen::Vector2d slip = pair.slip(displacement_of(states)) + pair.slip(of_part(increment));
    for (Eigen::Index d = 0; d < 2; ++d) free_.slip[unknown(i, d)] = slip[d];
  }
}

void ImplicitContact::solve(const std::vector<BodyState>& states, const Eigen::VectorXd& increment, bool again) {
  if (!frozen_ && !again) follow(states);
  if (frozen_ == participant::FrozenContact::open ||
      surface_.pairs.empty()) {  // or the bodies have slid off each other
    trial_.solution = root_->open();
    root_force_.setZero();
    return;
  }
  if (held()) {
    find_moved(states, increment);
    trial_.solution = root_->hold(free_.gap, free_.slip);
    root_force_.noalias() = response_.rows.transpose() * trial_.solution.force;
    return;
  }
  for (std::size_t i = 0; i < pairs(); ++i) {
    const auto& pair = surface_.pairs[i];
    free_.gap[unknown(i, 0)] = pair.gap(displacement_of(states)) + pair.normal.times(of_part(increment));
    if (directions() == 1) continue;
    const Eigen::Vector2d slip = pair.slip(of_part(increment)), rate = pair.slip(velocity_of(states));
    for (Eigen::Index d = 0; d < 2; ++d) {
      free_.slip[unknown(i, d)] = slip[d];
      free_.slip_velocity[unknown(i, d)] = rate[d];
    }
  }
  trial_.solution =
      root_->solve(free_.gap, free_.slip, free_.slip_velocity, state_.solution, again ? &trial_.solution : nullptr);
  solver::require_solved(trial_.solution);
  root_force_.noalias() = response_.rows.transpose() * trial_.solution.force;
}

double ImplicitContact::uncertain_force() const {
  const auto normal = trial_.solution.force.head(static_cast<Eigen::Index>(pairs()));
  return normal.size() > 0 ? trial_.solution.residual * normal.maxCoeff() : 0.0;
}

Eigen::Vector2d ImplicitContact::along_surface(std::size_t i, const Eigen::VectorXd& values) const {
  return {directions() > 1 ? values[unknown(i, 1)] : 0.0, directions() > 2 ? values[unknown(i, 2)] : 0.0};
}

void ImplicitContact::accept() {
  state_.solution = trial_.solution;
  before_.pairs.clear();
  state_.mean_forces = trial_.impulse;
  for (auto& force : state_.mean_forces) {
    force.normal /= dt_;
    force.tangential /= dt_;
  }
  state_.remembered = trial_.remembered;
  state_.uneven = trial_.uneven;
  state_.iterations += trial_.solution.iterations;
  state_.largest_residual = std::max(state_.largest_residual, trial_.solution.residual);
  state_.unconverged += trial_.solution.residual > solver::converged_contact_residual;
}

void ImplicitContact::start_open() {
  trial_.solution = root_->open();
  trial_.start(pairs(), by_impedance());
}

void ImplicitContact::open() {
  start_open();
  state_.solution = trial_.solution;
  state_.mean_forces = state_.remembered = trial_.impulse;
  state_.uneven = trial_.uneven;
  if (!massless_) return;
  const auto& settled = massless_->state().last.force;  // by which massless nodes are at rest
  for (std::size_t i = 0; i < pairs(); ++i) state_.remembered[i].normal = settled[unknown(i, 0)];
}

int ImplicitContact::pairs_closed() const {
  return static_cast<int>(state_.solution.states.size()) -
         static_cast<int>(std::count(state_.solution.states.begin(), state_.solution.states.end(), ContactState::open));
}

ImplicitContact::State ImplicitContact::state() const {
  State state = state_;
  if (massless_) state.massless = massless_->state();
  if (sliding_) state.sliding = sliding_->state();
  return state;
}

void ImplicitContact::restore(const State& state, const std::vector<BodyState>& states) {
  state_ = state;
  if (sliding_ && sliding_->restore(state.sliding, surface_.pairs)) {  // else the compliance stays, to the last bit
    before_.pairs.clear();
    take_new_pairs(states);
  }
  for (const auto count : {state.solution.states.size(), state.mean_forces.size(), state.remembered.size()})
    surface_.require_one_a_pair(count);
  if (by_impedance()) surface_.require_one_a_pair(state.uneven.size());
  surface_.require_one_a_pair(static_cast<std::size_t>(state.solution.force.size()),
                              static_cast<std::size_t>(directions()));
  if (massless_) massless_->restore(*state.massless);
  start_open();  // a flight accepts it as it stands, for as many pairs as there are now
}

const ContactRecord& ImplicitContact::report(const std::vector<BodyState>& states) {
  surface_.report(states, state_.mean_forces, state_, report_);
  return report_;
}

}  // namespace ricochet::implicit_solver
