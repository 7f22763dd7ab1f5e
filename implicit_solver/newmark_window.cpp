#include "implicit_solver/newmark_window.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/newmark.hpp"

namespace ricochet::implicit_solver {

namespace {
/// Three or four places will do in windows that follow a wave. The longest windows tried, in which a wave crosses
/// fourteen elements that yield without hardening, take some hundred.
constexpr int most_places = 1000;
}  // namespace

NewmarkWindow::NewmarkWindow(const CombinedParts& parts, ImplicitContact* contact, Eigen::MatrixXd interface_stiffness,
                             const WindowClock& clock, participant::Heartbeat* heart)
    : parts_(parts),
      contact_(contact),
      clock_(clock),
      dt_(clock.size_s()),
      interface_stiffness_(std::move(interface_stiffness)),
      holds_(parts.keep_tangents() && !parts.linear()),
      solver_(parts, contact, interface_stiffness_, dt_, heart),
      accepted_{solver_.linearised_at(), solver_.directions()},
      tried_(accepted_) {
  if (!parts.linear() && !holds_) newton_.predicted = newton_.no_link = Eigen::VectorXd::Zero(parts_.dofs());
  for (auto* vector : {&rhs_, &mean_velocity_, &newton_.imbalance}) vector->setZero(parts_.dofs());
  if (holds_) held_.change = held_.last_increment = rhs_;
  for (auto* vector : {&shared_x_, &shared_force_}) vector->setZero(interface_stiffness_.rows());
  for (const auto& state : parts_.states) dashpot_load_.emplace_back(state.dashpots.size(), 0.0);
  if (!contact_) return;
  for (const int dof : contact_->root_dofs()) {
    const std::size_t part = parts_.part_of(dof);
    roots_.push_back({dof, part, dof - static_cast<int>(parts_.offsets[part])});
  }
}

/// link += S x.
template <class Displacement>
void NewmarkWindow::add_stiffness_force(const Displacement& displacement, Eigen::VectorXd& link) {
  if (interface_stiffness_.size() == 0) return;
  Eigen::Index i = 0;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    for (const int dof : parts_.states[b].shared_dofs) shared_x_[i++] = displacement(b, dof);
  }
  shared_force_.noalias() = interface_stiffness_ * shared_x_;
  for (std::size_t k = 0; k < parts_.shared_dofs.size(); ++k)
    link[parts_.shared_dofs[k]] += shared_force_[static_cast<Eigen::Index>(k)];
}

void NewmarkWindow::add_interface_force(Eigen::VectorXd& link) {
  add_stiffness_force([&](std::size_t b, int dof) { return parts_.states[b].u[dof]; }, link);
}

void NewmarkWindow::add_interface_force_of(const Eigen::VectorXd& increment, Eigen::VectorXd& link) {
  add_stiffness_force([&](std::size_t b, int dof) { return increment[parts_.offsets[b] + dof]; }, link);
}

/// The right-hand side of the class comment without the link's change, and as much of the solve as does not need that.
void NewmarkWindow::prepare(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  if (prepared_ == window) return;
  if (solver_.linearised_at() != accepted_.linearised_at) solver_.linearise(accepted_.linearised_at);
  const double dt = dt_, quarter = 0.25 * dt * dt, time_s = clock_.time_s(window);
  parts_.external_force(time_s, trial.end.external);
  for (std::size_t b = 0; b < parts_.states.size(); ++b)
    for (std::size_t i = 0; i < parts_.states[b].dashpots.size(); ++i)
      dashpot_load_[b][i] = parts_.load_on(b, parts_.states[b].dashpots[i].dof, trial.end.external);
  if (!parts_.linear() && !holds_) {
    constrain_increment(time_s, trial);
    begin_balance(trial);
    prepared_ = window;
    return;
  }
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    parts_.segment(rhs_, b) =
        state.mass.cwiseProduct(dt * state.v + quarter * state.a) + quarter * parts_.segment(last.residual, b);
    if (!state.external.zero())
      parts_.segment(rhs_, b) += quarter * (parts_.segment(trial.end.external, b) - parts_.segment(last.external, b));
  }
  damp_rhs();
  constrain_increment(time_s, trial);
  if (holds_) predict(trial);
  solver_.eliminate(rhs_);
  prepared_ = window;
}

/// The first place of a window: the increment of the last one, and that of the constrained dofs.
void NewmarkWindow::predict(const WindowTrial& trial) {
  held_.place = held_.last_increment;
  for (std::size_t b = 0; b < parts_.states.size(); ++b)
    for (const auto& c : parts_.states[b].constrained)
      held_.place[parts_.offsets[b] + c.dof] = trial.increment[parts_.offsets[b] + c.dof];
  held_.change.setZero();
  steps_.clear();
  hold();
}

/// Elements hold what `held_.place` would change of them, and the right-hand side has it.
void NewmarkWindow::hold() {
  parts_.hold(dt_, held_.place, held_.next);
  rhs_ += 0.25 * dt_ * dt_ * (held_.next - held_.change);
  std::swap(held_.change, held_.next);
}

void NewmarkWindow::forget() {
  prepared_ = -1;
  parts_.let_go();
}

/// Adds the dashpots' forces in q and df that do not change with du: see the class comment.
void NewmarkWindow::damp_rhs() {
  const double dt = dt_;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    for (std::size_t i = 0; i < state.dashpots.size(); ++i) {
      const auto& d = state.dashpots[i];
      double change = 2.0 * d.coefficient_kg_s * state.v[d.dof];
      if (!state.external.zero()) change += d.force(state.v[d.dof]);  // df was formed with it in f_n
      rhs_[parts_.offsets[b] + d.dof] += 0.25 * dt * dt * change;
    }
  }
}

void NewmarkWindow::advance(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  prepare(window, last, trial);
  add_interface_force(trial.end.link);  // S du is in the operator
  if (parts_.linear() || holds_) {
    solver_.solve(rhs_, last.link, trial.end.link, nullptr, trial.increment);
    if (holds_) settle(window, last, trial);
  } else {
    solver_.solve(rhs_, newton_.no_link, trial.end.link, &newton_.predicted, trial.increment);
    balance(window, trial);
  }
  add_interface_force_of(trial.increment, trial.end.link);
  find_rates(trial);
  parts_.constrain_rates(clock_.time_s(window), dt_, last, trial);
}

/// The window is solved anew until what elements hold is near enough what flows where it ends.
void NewmarkWindow::settle(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  if (std::exchange(held_.window, window) != window) held_.places = 0;
  for (int places = 0; places < held_.places || !parts_.hold_enough(trial.increment); ++places) {
    Eigen::VectorXd step = trial.increment - held_.place;
    if (step.isZero(0.0)) return;
    if (places == most_places) {
      throw SolverError(fmt::format("window {}: what yields does not settle in {} solves; use a smaller time.step_s",
                                    window, most_places));
    }
    held_.places = std::max(held_.places, places + 1);
    prepared_ = -1;  // rhs_ is another
    mend(step);
    held_.place += step;
    remember(std::move(step));
    hold();
    solver_.eliminate(rhs_);
    solver_.solve(rhs_, last.link, trial.end.link, nullptr, trial.increment);
  }
}

/// Given increments of the constrained dofs, and what they push on the free ones: b_f -= dt^2/4 K_fc du_c.
void NewmarkWindow::constrain_increment(double time_s, WindowTrial& trial) {
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    for (const auto& c : parts_.states[b].constrained) {
      const double du = c.at(time_s) - parts_.states[b].u[c.dof];
      trial.increment[parts_.offsets[b] + c.dof] = du;
      if (du != 0.0) solver_.subtract_moved(b, c.dof, du, rhs_);
    }
  }
}

void NewmarkWindow::begin_with(const Eigen::VectorXd& linearised_at, const std::vector<Eigen::Matrix3d>& directions) {
  if (solver_.linearised_at() != linearised_at) solver_.linearise(linearised_at);
  if (solver_.directions() != directions) solver_.turn(directions);
  accepted_ = tried_ = {solver_.linearised_at(), directions};
  forget();
}

/// a*, v* and q of the class comment; the velocity and acceleration of closed pairs.
void NewmarkWindow::find_rates(WindowTrial& trial) {
  const double dt = dt_;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    auto a = parts_.segment(trial.acceleration, b);
    a = (4.0 / (dt * dt)) * (parts_.segment(trial.increment, b) - dt * state.v) - state.a;
    parts_.segment(trial.velocity, b) = fem::corrected_velocity(state.v, state.a, a, dt);
    parts_.segment(trial.end.residual, b) = state.mass.cwiseProduct(a);
  }
  if (contact_) find_contact_rates(trial);
  set_dashpot_forces(trial);
}

/// Takes the contact forces out of q (and, where the law does not remember them, out of a), then applies Eq. 25.
void NewmarkWindow::find_contact_rates(WindowTrial& trial) {
  const Eigen::VectorXd& force = contact_->root_force();
  for (std::size_t i = 0; i < roots_.size(); ++i) {
    const auto& [dof, part, local] = roots_[i];
    const auto& state = parts_.states[part];
    const double applied = contact_->kappa() * force[static_cast<Eigen::Index>(i)];
    trial.end.residual[dof] -= applied;
    if (state.mass[local] == 0.0) {  // massless: it has no rates of its own
      trial.velocity[dof] = trial.increment[dof] / dt_;
      trial.acceleration[dof] = 0.0;
    }
    mean_velocity_[dof] = trial.velocity[dof];
    if (!contact_->remembered()) trial.acceleration[dof] = trial.end.residual[dof] * state.inverse_mass[local];
  }
  contact_->update_rates(parts_.states, trial.increment, trial.velocity, trial.acceleration);
  for (const auto& root : roots_)
    mean_velocity_[root.dof] = 0.5 * (mean_velocity_[root.dof] + trial.velocity[root.dof]);
}

/// The dashpots' forces at n + 1 join f.
void NewmarkWindow::set_dashpot_forces(WindowTrial& trial) const {
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    for (std::size_t i = 0; i < parts_.states[b].dashpots.size(); ++i) {
      const auto& d = parts_.states[b].dashpots[i];
      const auto dof = parts_.offsets[b] + d.dof;
      trial.end.external[dof] = dashpot_load_[b][i] + d.force(trial.velocity[dof]);
    }
  }
}

void NewmarkWindow::account(const WindowTrial& trial) {
  accepted_ = tried_;
  if (holds_) held_.last_increment = trial.increment;
  if (contact_) contact_->account(parts_.states, trial.increment, mean_velocity_);
}

}  // namespace ricochet::implicit_solver
