#include "explicit_solver/motion_driven.hpp"

#include <utility>

#include "common/body/central_difference.hpp"

namespace ricochet::explicit_solver {

MotionDriven::MotionDriven(std::vector<solver::BodyState>& states, std::optional<ExplicitContact> contact,
                           const WindowClock& clock, const MakeForce& make_force)
    : states_(states), clock_(clock), contact_(std::move(contact)) {
  state_.parts.resize(states_.size());
  trials_.resize(states_.size());
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    auto& forces = state_.parts[b];
    forces.internal.resize(state.part.dofs());
    state.stiffness.multiply(state.u, forces.internal);
    forces.external.setZero(state.part.dofs());
    state.external.at(0.0, forces.external);
    trials_[b].u = state.u;
    trials_[b].forces = forces;
  }
  for (auto& trial : trials_) {
    u_before_.push_back(&trial.u);
    trial_u_.push_back(&trial.u);
    trial_external_.push_back(&trial.forces.external);
  }
  if (contact_) settle_at_start();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    forces_.push_back(make_force(states_[b], driven_nodes(b)));
    spread_loads(b);
  }
  if (!loads_inside_) left_out_loads_.clear();
  if (contact_) contact_->act_through(forces_, states_);
}

/// S f of the loads, once and for all. S of a part that turns turns with it: each window spreads the loads it has.
void MotionDriven::spread_loads(std::size_t b) {
  auto& state = states_[b];
  left_out_loads_.push_back(state.external);
  if (state.frame) {
    bool inside = false;
    for (int dof = 0; dof < state.part.dofs() && !inside; ++dof) inside = forces_[b]->spreads(dof);
    if (!inside || state.external.zero()) return;
    loads_inside_ = true;
    for (auto* forces : {&state_.parts[b], &trials_[b].forces}) forces->left_out.setZero(state.part.dofs());
    return;
  }
  state.external.transform([&](Eigen::VectorXd& load) { forces_[b]->spread(load); });
  left_out_loads_[b].transform([&](Eigen::VectorXd& load) {
    Eigen::VectorXd spread = load;
    forces_[b]->spread(spread);
    load -= spread;
    loads_inside_ = loads_inside_ || !load.isZero(0.0);
  });
}

void MotionDriven::spread_load(std::size_t b) {
  auto& forces = trials_[b].forces;
  if (forces.left_out.size() == 0) return;
  forces.left_out = forces.external;
  forces_[b]->spread(forces.external);
  forces.left_out -= forces.external;
}

/// Massless contact nodes begin in balance with the others.
void MotionDriven::settle_at_start() {
  contact_->move_masses(states_);
  contact_->settle(states_, trial_external_, trial_u_);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    states_[b].u = trials_[b].u;
    states_[b].stiffness.multiply(states_[b].u, state_.parts[b].internal);
  }
}

/// Shared and contact nodes.
std::vector<int> MotionDriven::driven_nodes(std::size_t b) const {
  std::vector<int> nodes = states_[b].shared_nodes;
  if (!contact_) return nodes;
  for (const auto& pair : contact_->surface().pairs) {
    for (const auto& e : pair.normal.entries) {
      if (e.part == static_cast<int>(b)) nodes.push_back(e.dof / contact_->surface().components);
    }
  }
  for (const auto& idle : contact_->surface().idle) {
    if (idle.part == static_cast<int>(b)) nodes.push_back(idle.node);
  }
  return nodes;
}

void MotionDriven::answer(participant::LinkOutput& output) const {
  output.value.clear();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& forces = answered_with_trial_ ? trials_[b].forces : state_.parts[b];
    for (const int dof : states_[b].shared_dofs) output.value.push_back(forces.internal[dof] - forces.external[dof]);
  }
}

void MotionDriven::synchronise(std::int64_t window, const std::vector<double>& link_input) {
  std::size_t next = 0;
  const double time_s = clock_.time_s(window);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    auto& trial = trials_[b];
    trial.u = state.u;
    for (const int dof : state.shared_dofs) state.u[dof] = link_input[next++];
    forces_[b]->evaluate(0.0, state.u, trial.forces.internal);
    state.external.at(time_s, trial.forces.external);
    account_interface(b);
  }
  find_accelerations(time_s, Velocity::now);
  keep_trial_forces();
  for (auto& state : states_) state.constrain_velocity(time_s, dt(), state.v);
}

void MotionDriven::reconfigure() {
  predicted_ = answered_with_trial_ = false;
  if (contact_ && state_.contact_started) contact_->reconfigure(states_);
}

void MotionDriven::advance(std::int64_t window, const std::vector<double>& link_input) {
  if (!predicted_) predict(window);
  std::size_t next = 0;
  for (std::size_t b = 0; b < states_.size(); ++b) move_shared(b, link_input, next);
  answered_with_trial_ = true;
}

void MotionDriven::work_ahead(std::int64_t window) {
  if (!predicted_) predict(window);
}

/// Everything of a window that does not need the link: u of the own nodes, what of P needs no shared node, f.
void MotionDriven::predict(std::int64_t window) {
  const double time_s = clock_.time_s(window);
  if (contact_ && !state_.contact_started) {
    contact_->start(states_);
    for (std::size_t b = 0; b < states_.size(); ++b) contact_->add_reactions(b, states_[b], state_.parts[b].external);
  }
  state_.contact_started = true;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    auto& trial = trials_[b];
    solver::step_displacement(state, time_s, dt(), state.u, state.v, state.a, trial.u);
    for (const int dof : state.shared_dofs) trial.u[dof] = state.u[dof];
    if (!state.external.zero()) state.external.at(time_s, trial.forces.external);
  }
  if (contact_) contact_->settle(states_, trial_external_, trial_u_);
  for (std::size_t b = 0; b < states_.size(); ++b)
    forces_[b]->before_link(dt(), trials_[b].u, trials_[b].forces.internal);
  predicted_ = true;
}

/// u_Gamma of the link, and what it changes of P.
void MotionDriven::move_shared(std::size_t b, const std::vector<double>& link_input, std::size_t& next) {
  auto& trial = trials_[b];
  for (const int dof : states_[b].shared_dofs) trial.u[dof] = link_input[next++];
  forces_[b]->after_link(dt(), trial.u, trial.forces.internal);
}

bool MotionDriven::accept(std::int64_t window) {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    half_a_step(b);
    states_[b].u.swap(trials_[b].u);
    set_shared_velocity(b);
  }
  const double time_s = clock_.time_s(window);
  find_accelerations(time_s, Velocity::half_a_step_before);
  for (const auto& state : states_) {
    if (state.others != nullptr) state.others->collect_moments(state);
  }
  if (contact_) contact_->apply(states_, u_before_);
  for (std::size_t b = 0; contact_ && b < states_.size(); ++b)
    contact_->add_reactions(b, states_[b], trials_[b].forces.external);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    half_a_step(b);
    states_[b].constrain_velocity(time_s, dt(), states_[b].v);
  }
  if (contact_) contact_->finish(states_, u_before_);
  account();
  if (loads_inside_) account_left_out_loads(time_s);
  keep_trial_forces();
  return true;
}

void MotionDriven::keep_trial_forces() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    state_.parts[b].internal.swap(trials_[b].forces.internal);
    state_.parts[b].external.swap(trials_[b].forces.external);
    state_.parts[b].left_out.swap(trials_[b].forces.left_out);
  }
  predicted_ = answered_with_trial_ = false;
}

/// The link says where shared nodes are, not how fast: their mean velocity over the window, for the fields. Nothing
/// else reads it.
void MotionDriven::set_shared_velocity(std::size_t b) {
  auto& state = states_[b];
  for (const int dof : state.shared_dofs) state.v[dof] = (state.u[dof] - trials_[b].u[dof]) / dt();
}

/// v += dt/2 a, where there is an acceleration.
void MotionDriven::half_a_step(std::size_t b) {
  auto& state = states_[b];
  for (const auto& [first, last] : forces_[b]->rows()) {
    const auto count = last - first;
    state.v.segment(first, count) += (0.5 * dt()) * state.a.segment(first, count);
  }
}

/// a = M^-1 (f - P) of the trial's forces, the given motion at constrained dofs; the reactions there join f.
void MotionDriven::find_accelerations(double time_s, Velocity velocity) {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    const Eigen::VectorXd& internal = trials_[b].forces.internal;
    Eigen::VectorXd& external = trials_[b].forces.external;
    forces_[b]->follow(internal);
    forces_[b]->settle();
    spread_load(b);
    if (velocity == Velocity::now) {
      for (const auto& d : state.dashpots) external[d.dof] += d.force(state.v[d.dof]);
    } else {
      const auto others = [&](int dof, double load) { return load - internal[dof]; };
      solver::add_dashpot_forces(
          state, dt(), [&](int dof) { return state.v[dof]; }, others, external);
    }
    for (const auto& [first, last] : forces_[b]->rows()) {
      const auto count = last - first;
      state.a.segment(first, count) =
          state.inverse_mass.segment(first, count)
              .cwiseProduct(external.segment(first, count) - internal.segment(first, count));
    }
    state.constrain_acceleration(time_s, dt(), state.a);
    solver::set_reactions(state, time_s, dt(), internal, external);
  }
}

void MotionDriven::account() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto &before = state_.parts[b].external, &after = trials_[b].forces.external;
    const auto &u = states_[b].u, &u_before = trials_[b].u;
    states_[b].account_external(
        dt(), [&](int dof) { return 0.5 * (before[dof] + after[dof]); },
        [&](int dof) { return u[dof] - u_before[dof]; }, [&](int dof) { return 0.5 * (u[dof] + u_before[dof]); });
    account_interface(b);
  }
}

/// While the part moves by the window's increment, one degree of freedom after another.
double MotionDriven::work_of_left_out(std::size_t b, const Eigen::VectorXd& load) const {
  double work_j = 0.0;
  for (Eigen::Index dof = 0; dof < load.size(); ++dof)
    if (load[dof] != 0.0) work_j += load[dof] * (states_[b].u[dof] - trials_[b].u[dof]);
  return work_j;
}

/// Loads do f . du, of which the work inside small steps has S f . du.
void MotionDriven::account_left_out_loads(double time_s) {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    if (state.external.zero()) continue;
    if (const auto& now = trials_[b].forces.left_out; now.size() > 0) {
      state.totals.energy_external_j += 0.5 * work_of_left_out(b, state_.parts[b].left_out + now);
      continue;
    }
    for (const double at_s : {time_s - dt(), time_s}) {
      left_out_load_.resize(state.part.dofs());
      left_out_loads_[b].at(at_s, left_out_load_);
      state.totals.energy_external_j += 0.5 * work_of_left_out(b, left_out_load_);
    }
  }
}

/// Work the link does on the explicit elements while it moves their shared nodes: 1/2 (P_old + P_new) . du.
void MotionDriven::account_interface(std::size_t b) {
  const auto &before = state_.parts[b], &after = trials_[b].forces;
  auto& state = states_[b];
  for (const int dof : state.shared_dofs) {
    const double force = (before.internal[dof] - before.external[dof]) + (after.internal[dof] - after.external[dof]);
    state.totals.energy_interface_j += 0.5 * force * (state.u[dof] - trials_[b].u[dof]);
  }
}

MotionDriven::State MotionDriven::state() const {
  State state = state_;
  for (const auto& force : forces_) state.elements.push_back(kept_by(*force));
  if (contact_) state.contact = contact_->state();
  return state;
}

void MotionDriven::restore(const State& state) {
  state_ = state;
  state_.elements.clear();  // `state` asks the forces, also after a restore that was refused halfway
  for (std::size_t b = 0; b < states_.size(); ++b) put_back(state.elements[b], *forces_[b]);
  if (contact_) contact_->restore(*state.contact);  // whose forces act through those
  for (std::size_t b = 0; b < states_.size(); ++b) {
    trials_[b].forces =
        state_.parts[b];  // rows that are not computed are never written: they must hold what they held then
  }
  predicted_ = answered_with_trial_ = false;
}

void MotionDriven::freeze(participant::FrozenContact contact) {
  if (contact_) contact_->freeze(contact);
  State state = this->state();
  for (auto& forces : state.parts) forces.external.setZero();
  state.contact_started = false;  // a_n contains the contact force that closes the gap at n + 1
  restore(state);
  for (auto& force : forces_) force->reach_all();  // the motion may be any
}

}  // namespace ricochet::explicit_solver
