#include "implicit_solver/flight_window.hpp"

#include "common/body/central_difference.hpp"

namespace ricochet::implicit_solver {

FlightWindow::FlightWindow(const CombinedParts& parts, ImplicitContact* contact, const WindowClock& clock)
    : parts_(parts), contact_(contact), clock_(clock) {
  for (const auto& state : parts_.states) moved_.push_back(state.u);
  internal_ = moved_;
}

void FlightWindow::settle_at_start(const Eigen::VectorXd& external) {
  settle(external);
  for (std::size_t b = 0; b < parts_.size(); ++b) parts_.states[b].u = moved_[b];
}

/// The massless nodes' displacement in `moved_`, from that of the others there.
void FlightWindow::settle(const Eigen::VectorXd& external) {
  if (!contact_ || !contact_->massless()) return;
  part_external_.resize(parts_.size());
  for (std::size_t b = 0; b < parts_.size(); ++b) part_external_[b] = parts_.segment(external, b);
  contact_->settle(parts_.states, part_external_, moved_);
}

void FlightWindow::advance(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  const double time_s = clock_.time_s(window), dt = clock_.size_s(window);
  if (contact_) contact_->fly(parts_.states);
  parts_.external_force(time_s, trial.end.external);
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const auto& state = parts_.states[b];
    auto increment = parts_.segment(trial.increment, b);
    increment = fem::predicted_increment(state.v, state.a, dt, fem::beta_explicit);
    for (const auto& c : state.constrained) increment[c.dof] = c.at(time_s) - state.u[c.dof];
    moved_[b] = state.u + increment;
  }
  settle(trial.end.external);
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const auto& state = parts_.states[b];
    parts_.forces[b]->evaluate(dt, moved_[b], internal_[b]);
    const auto link = parts_.segment(trial.end.link, b);
    solver::add_dashpot_forces(
        state, dt, [&](int dof) { return state.v[dof] + 0.5 * dt * state.a[dof]; },
        [&](int dof, double load) { return load - link[dof] - internal_[b][dof]; },
        parts_.segment(trial.end.external, b));
    auto residual = parts_.segment(trial.end.residual, b);
    auto acceleration = parts_.segment(trial.acceleration, b);
    residual = parts_.segment(trial.end.external, b) - link - internal_[b];
    acceleration = state.inverse_mass.cwiseProduct(residual);
    parts_.segment(trial.velocity, b) = fem::corrected_velocity(state.v, state.a, acceleration, dt);
  }
  if (contact_ && contact_->massless()) {
    for (std::size_t b = 0; b < parts_.size(); ++b) parts_.segment(trial.increment, b) = moved_[b] - parts_.states[b].u;
    contact_->set_massless_velocity(trial.increment, trial.velocity);
  }
  parts_.constrain_rates(time_s, dt, last, trial);
}

}  // namespace ricochet::implicit_solver
