#include "explicit_solver/explicit_solver.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/base/error.hpp"
#include "common/fem/newmark.hpp"
#include "common/solver/describe.hpp"

namespace ricochet::explicit_solver {

using participant::Link;

ExplicitSolver::ExplicitSolver(scene::Problem problem, const std::string& name)
    : problem_(std::move(problem)), spec_(&problem_.scene.participant(name)) {
  if (spec_->role != scene::Role::explicit_solver) {
    throw ConfigError(fmt::format("{}: participant '{}' has role \"implicit\"; start implicit_solver for it, or set its role "
                                  "to \"explicit\"", problem_.scene.path, name));
  }
  states_ = solver::initial_states(problem_, *spec_, false);
  windows_.resize(states_.size());
  for (const auto& window : windows_) u_before_.push_back(&window.u);
}

participant::Description ExplicitSolver::describe() {
  const bool alone = problem_.scene.coupling.protocol == "all_explicit";
  auto description = solver::describe(problem_, *spec_, states_, alone && !problem_.contact.pairs.empty());
  description.solver = "ricochet explicit_solver";
  description.capabilities = {"repeat_window"};
  return description;
}

void ExplicitSolver::initialize(const participant::Setup& setup, Link& output) {
  setup_ = setup;
  separation_ = solver::SeparationWatch(setup.separation_windows, setup.window_size_s);
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& window = windows_[b];
    window.u = states_[b].u;
    window.internal.resize(states_[b].part.dofs());
    states_[b].stiffness.multiply(states_[b].u, window.internal);
    window.internal_old = window.internal;
    window.external.setZero(states_[b].part.dofs());
    states_[b].external.at(0.0, window.external);
    window.external_old = window.external;
  }
  if (problem_.scene.coupling.protocol == "all_explicit" && !problem_.contact.pairs.empty()) {
    contact_.emplace(problem_, scene::participant_parts(problem_, *spec_), setup.window_size_s);
  }
  interface_force(output);
}

void ExplicitSolver::take_link(const solver::BodyState& state, const std::vector<double>& link_input, std::size_t& next,
                               Eigen::VectorXd& u) const {
  for (const int dof : state.shared_dofs) u[dof] = link_input[next++];
}

void ExplicitSolver::interface_force(Link& output) const {
  output.value.clear();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (const int dof : states_[b].shared_dofs) output.value.push_back(windows_[b].internal[dof] - windows_[b].external[dof]);
  }
}

/// Work the link does on the explicit elements while it moves their shared nodes: 1/2 (P_old + P_new) . du.
void ExplicitSolver::account_interface(std::size_t b, const Eigen::VectorXd& u_old, const Eigen::VectorXd& u_new) {
  const auto& w = windows_[b];
  auto& totals = states_[b].totals;
  for (const int dof : states_[b].shared_dofs) {
    const double force = (w.internal_old[dof] - w.external_old[dof]) + (w.internal[dof] - w.external[dof]);
    totals.energy_interface_j += 0.5 * force * (u_new[dof] - u_old[dof]);
  }
}

void ExplicitSolver::synchronise(participant::Integration, const std::vector<double>& link_input, Link& output) {
  std::size_t next = 0;
  const double time_s = static_cast<double>(window_) * setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& window = windows_[b];
    window.u = states_[b].u;
    take_link(states_[b], link_input, next, states_[b].u);
    window.internal_old.swap(window.internal);
    states_[b].stiffness.multiply(states_[b].u, window.internal);
    window.external_old = window.external;
    account_interface(b, window.u, states_[b].u);
  }
  find_accelerations(time_s);
  for (auto& state : states_) state.constrain_velocity(time_s, setup_.window_size_s, state.v);
  interface_force(output);
  update_status();
}

void ExplicitSolver::advance(std::int64_t window, const std::vector<double>& link_input, Link& output) {
  const double dt = setup_.window_size_s;
  const double time_s = static_cast<double>(window) * dt;
  if (contact_ && window_ == 0 && !trial_) contact_->start(states_);
  std::size_t next = 0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    auto& w = windows_[b];
    if (!trial_) {
      w.internal.swap(w.internal_old);
      w.external.swap(w.external_old);
    }
    w.u = fem::predicted_displacement(state.u, state.v, state.a, dt, fem::beta_explicit);
    state.constrain_displacement(time_s, w.u);
    take_link(state, link_input, next, w.u);
    state.stiffness.multiply(w.u, w.internal);
    state.external.at(time_s, w.external);
  }
  trial_ = true;
  interface_force(output);
}

void ExplicitSolver::accept() {
  const double dt = setup_.window_size_s;
  ++window_;
  trial_ = false;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    states_[b].v += (0.5 * dt) * states_[b].a;
    states_[b].u.swap(windows_[b].u);
  }
  const double time_s = static_cast<double>(window_) * dt;
  find_accelerations(time_s);
  if (contact_) contact_->apply(states_, u_before_);
  for (auto& state : states_) {
    state.v += (0.5 * dt) * state.a;
    state.constrain_velocity(time_s, dt, state.v);
  }
  account();
  update_status();
}

/// a = M^-1 (f - K u), the given motion at constrained dofs; the reactions there, R = M a + K u - f, join f.
void ExplicitSolver::find_accelerations(double time_s) {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    auto& w = windows_[b];
    state.a = state.inverse_mass.cwiseProduct(w.external - w.internal);
    state.constrain_acceleration(time_s, setup_.window_size_s, state.a);
    for (const auto& c : state.constrained) w.external[c.dof] = state.mass[c.dof] * state.a[c.dof] + w.internal[c.dof];
  }
}

void ExplicitSolver::account() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& w = windows_[b];
    const auto& u = states_[b].u;
    states_[b].account_external(
        setup_.window_size_s, [&](int dof) { return 0.5 * (w.external_old[dof] + w.external[dof]); },
        [&](int dof) { return u[dof] - w.u[dof]; });
    account_interface(b, w.u, states_[b].u);
  }
}

void ExplicitSolver::update_status() {
  if (!contact_) return;
  status_ = solver::contact_status(contact_->surface(), states_, contact_->pairs_closed(), window_, setup_, separation_);
}

void ExplicitSolver::record(std::vector<double>& row) {
  const double dt = setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    auto& state = states_[b];
    solver::require_finite(state, state.u, window_);
    state.update_momentum();
    const double kinetic = (state.mass.array() * state.v.array().square()).sum();
    const double staggered = 0.25 * dt * dt * (state.mass.array() * state.a.array().square()).sum();
    state.totals.energy_kinetic_j = 0.5 * (kinetic - staggered);
    state.totals.energy_strain_j = 0.5 * state.u.dot(windows_[b].internal);
  }
  solver::record_bodies(states_, row);
  if (contact_) solver::append(contact_->report(states_), row);
}

void ExplicitSolver::write_fields(std::int64_t window) {
  solver::write_fields(setup_.output_directory, spec_->name, window, states_);
}

}  // namespace ricochet::explicit_solver
