#include "implicit_solver/newmark_window.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/mesh.hpp"
#include "common/fem/newmark.hpp"

namespace ricochet::implicit_solver {

namespace {
/// Newton's iteration ends when what is out of balance is so much of the largest force, or when that or an improvement
/// is what the rounding of displacements makes: of u, of its increment, of the size of a part that turns.
constexpr double balanced_share = 1e-10, rounding_share = 4.0 * std::numeric_limits<double>::epsilon();
/// Improvements by one tangent go on while each leaves no more than so much of what was out of balance: ten solves then
/// take it from 1 to 1e-7, and a factorisation costs more than ten.
constexpr double slow_share = 0.2;
constexpr int most_improvements = 50;
/// Elements that keep their tangent take ten to twenty. The longest windows tried, in which a wave crosses fourteen
/// elements that yield without hardening, take some hundred.
constexpr int most_improvements_by_one_tangent = 2000;
/// Steps that are remembered, a vector each.
constexpr std::size_t most_steps = 50;
/// Where they would lengthen a step by more, they are forgotten.
constexpr double most_growth = 1e4;
/// An improvement that goes too far is shortened until the slope of the window's potential along it is so much of what
/// it was at its beginning, or less.
constexpr double level_share = 0.1;
constexpr int most_shortenings = 20;
}  // namespace

NewmarkWindow::NewmarkWindow(const CombinedParts& parts, ImplicitContact* contact, Eigen::MatrixXd interface_stiffness,
                             const WindowClock& clock, participant::Heartbeat* heart)
    : parts_(parts),
      contact_(contact),
      clock_(clock),
      dt_(clock.size_s()),
      interface_stiffness_(std::move(interface_stiffness)),
      solver_(parts, contact, interface_stiffness_, dt_, heart),
      linearised_at_(solver_.linearised_at()),
      trial_linearised_at_(linearised_at_) {
  for (auto* vector : {&rhs_, &mean_velocity_, &imbalance_}) vector->setZero(parts_.dofs());
  for (auto* vector : {&shared_x_, &shared_force_}) vector->setZero(interface_stiffness_.rows());
  for (const auto& state : parts_.states) dashpot_load_.emplace_back(state.dashpots.size(), 0.0);
  if (!contact_) return;
  for (const int dof : contact_->root_dofs()) {
    std::size_t part = parts_.states.size() - 1;
    while (dof < parts_.offsets[part]) --part;
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

/// The right-hand side of the class comment without the link's change, and as much of the solve as does not need that.
void NewmarkWindow::prepare(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  if (prepared_ == window) return;
  if (solver_.linearised_at() != linearised_at_) solver_.linearise(linearised_at_);
  const double dt = dt_, quarter = 0.25 * dt * dt, time_s = clock_.time_s(window);
  parts_.external_force(time_s, trial.end.external);
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    parts_.segment(rhs_, b) =
        state.mass.cwiseProduct(dt * state.v + quarter * state.a) + quarter * parts_.segment(last.residual, b);
    if (!state.external.zero())
      parts_.segment(rhs_, b) += quarter * (parts_.segment(trial.end.external, b) - parts_.segment(last.external, b));
  }
  damp_rhs(trial);
  constrain_increment(time_s, trial);
  solver_.eliminate(rhs_);
  prepared_ = window;
}

/// Of the dashpots' forces in q and df, what does not change with du: see the class comment.
void NewmarkWindow::damp_rhs(const WindowTrial& trial) {
  const double dt = dt_;
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    for (std::size_t i = 0; i < state.dashpots.size(); ++i) {
      const auto& d = state.dashpots[i];
      dashpot_load_[b][i] = parts_.load_on(b, d.dof, trial.end.external);
      double change = 2.0 * d.coefficient_kg_s * state.v[d.dof];
      if (!state.external.zero()) change += d.force(state.v[d.dof]);  // df was formed with it in f_n
      rhs_[parts_.offsets[b] + d.dof] += 0.25 * dt * dt * change;
    }
  }
}

void NewmarkWindow::advance(std::int64_t window, const WindowState& last, WindowTrial& trial) {
  prepare(window, last, trial);
  add_interface_force(trial.end.link);  // S du is in the operator
  solver_.solve(rhs_, last.link, trial.end.link, trial.increment);
  if (!parts_.linear()) balance(window, trial);
  add_stiffness_force([&](std::size_t b, int dof) { return trial.increment[parts_.offsets[b] + dof]; }, trial.end.link);
  find_rates(trial);
  parts_.constrain_rates(clock_.time_s(window), dt_, last, trial);
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

void NewmarkWindow::linearise(const Eigen::VectorXd& u) {
  solver_.linearise(u);
  linearised_at_ = trial_linearised_at_ = solver_.linearised_at();
  forget();
}

/// Newton's iteration where the elements are not linear: each step is a linear window for what the last one left out of
/// balance, with contact forces found anew. The operator stays while it serves, and what its steps have shown of the
/// difference to the tangent mends the next ones.
void NewmarkWindow::balance(std::int64_t window, WindowTrial& trial) {
  const double quarter = 0.25 * dt_ * dt_;
  double before_n = std::numeric_limits<double>::infinity(), largest_n = find_imbalance(trial);
  steps_.clear();
  const int most = parts_.keep_tangents() ? most_improvements_by_one_tangent : most_improvements;
  for (int improvements = 0;; ++improvements) {
    const Eigen::VectorXd left = imbalance_with_contact();
    const double left_n = left.lpNorm<Eigen::Infinity>();
    double moved_m = 0.0;
    if (is_balanced(left, largest_n, trial, moved_m)) break;
    if (!std::isfinite(left_n) &&
        !steps_.empty()) {  // mended too far: from the last place again, by the operator alone
      steps_.clear();
      trial.increment = before_;
      largest_n = find_imbalance(trial);
      continue;
    }
    if (improvements == most || !std::isfinite(left_n)) refuse_unbalanced(window, improvements, left);
    if (!parts_.keep_tangents() && left_n > slow_share * before_n) {
      solver_.linearise(parts_.displacement() + trial.increment);
      steps_.clear();
    }
    before_n = left_n;
    before_ = trial.increment;
    rhs_ = quarter * imbalance_;
    solver_.improve(rhs_, trial.increment);
    Eigen::VectorXd step = trial.increment - before_;
    mend(step);
    trial.increment = before_ + step;
    largest_n = find_imbalance(trial);
    if (shorten(step, trial, largest_n) || steps_.size() == most_steps) {
      steps_.clear();
    } else {
      steps_.push_back(step);
    }
    if ((trial.increment - before_).lpNorm<Eigen::Infinity>() <= rounding_share * moved_m) break;
  }
  trial_linearised_at_ = solver_.linearised_at();
  forget();  // rhs_ is another
}

/// By the rounding of each part alone: a stiff one says nothing of what its partner may leave. `moved_m`: the largest
/// number that is rounded.
bool NewmarkWindow::is_balanced(const Eigen::VectorXd& left, double largest_n, const WindowTrial& trial,
                                double& moved_m) const {
  bool balanced = true;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (parts_.states[b].part.dofs() == 0) continue;
    const double own_m = std::max({parts_.states[b].u.lpNorm<Eigen::Infinity>(),
                                   parts_.segment(trial.increment, b).lpNorm<Eigen::Infinity>(), parts_.turning_m(b)});
    const double rounded_n = rounding_share * own_m * solver_.stiffest_n_m(b);
    balanced = balanced &&
               parts_.segment(left, b).lpNorm<Eigen::Infinity>() <= std::max(balanced_share * largest_n, rounded_n);
    moved_m = std::max(moved_m, own_m);
  }
  return balanced;
}

/// Broyden's method by its steps (Kelley: Iterative Methods for Linear and Nonlinear Equations, 1995, section 7.3): the
/// step that the operator finds becomes that of the operator which all steps so far have changed as little as would
/// have made them right.
void NewmarkWindow::mend(Eigen::VectorXd& step) {
  if (steps_.empty()) return;
  Eigen::VectorXd mended = step;
  const auto along = [&](const Eigen::VectorXd& earlier) { return earlier.dot(mended) / earlier.squaredNorm(); };
  for (std::size_t k = 0; k + 1 < steps_.size(); ++k) mended += along(steps_[k]) * steps_[k + 1];
  const double shrinks = 1.0 - along(steps_.back());
  if (std::abs(shrinks) * most_growth > 1.0) {
    step = mended / shrinks;
  } else {
    steps_.clear();
  }
}

/// Elements that soften and stiffen again, as where they yield and unload, have Newton's steps swing to and fro over
/// the minimum of the window's potential. Its slope along a step is minus what is out of balance; where the step ends
/// uphill, the place between is found where it is level (false position). Contact forces are those that the step found.
/// Returns whether it was.
bool NewmarkWindow::shorten(const Eigen::VectorXd& step, WindowTrial& trial, double& largest_n) {
  double by_contact = 0.0;
  for (std::size_t i = 0; i < roots_.size(); ++i)
    by_contact += contact_->kappa() * contact_->root_force()[static_cast<Eigen::Index>(i)] * step[roots_[i].dof];
  const double first = 4.0 / (dt_ * dt_) * rhs_.dot(step) + by_contact;
  double low = 0.0, at_low = first, high = 1.0, at_high = imbalance_.dot(step) + by_contact;
  if (!(first > 0.0) || !(at_high < -0.5 * first)) return false;
  double share = 1.0, slope = at_high;
  for (int k = 0; k < most_shortenings && std::abs(slope) > level_share * first; ++k) {
    share = k % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
    trial.increment = before_ + share * step;
    largest_n = find_imbalance(trial);
    slope = imbalance_.dot(step) + by_contact;
    (slope > 0.0 ? low : high) = share;
    (slope > 0.0 ? at_low : at_high) = slope;
  }
  return true;
}

/// f - P - L - M a* at the free dofs for the present increment, without contact forces. Returns the largest of the
/// forces.
double NewmarkWindow::find_imbalance(const WindowTrial& trial) {
  const double dt = dt_;
  double largest = 0.0;
  link_ = trial.end.link;
  add_stiffness_force([&](std::size_t b, int dof) { return trial.increment[parts_.offsets[b] + dof]; }, link_);
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    const auto du = parts_.segment(trial.increment, b);
    parts_.evaluate_moved(dt_, b, trial.increment, internal_);
    inertia_ = state.mass.cwiseProduct((4.0 / (dt * dt)) * (du - dt * state.v) - state.a);
    auto left = parts_.segment(imbalance_, b);
    left = parts_.segment(trial.end.external, b);
    for (std::size_t i = 0; i < state.dashpots.size(); ++i) {
      const auto& d = state.dashpots[i];
      left[d.dof] = dashpot_load_[b][i] + d.force(2.0 / dt * du[d.dof] - state.v[d.dof]);
    }
    left -= parts_.segment(link_, b);
    for (int dof = 0; dof < state.part.dofs(); ++dof) {
      if (!state.free[static_cast<std::size_t>(dof)]) left[dof] = internal_[dof] = inertia_[dof] = 0.0;
    }
    for (const double n :
         {left.lpNorm<Eigen::Infinity>(), internal_.lpNorm<Eigen::Infinity>(), inertia_.lpNorm<Eigen::Infinity>()})
      largest = std::max(largest, n);
    left -= internal_ + inertia_;
  }
  return largest;
}

Eigen::VectorXd NewmarkWindow::imbalance_with_contact() const {
  Eigen::VectorXd left = imbalance_;
  for (std::size_t i = 0; i < roots_.size(); ++i)
    left[roots_[i].dof] += contact_->kappa() * contact_->root_force()[static_cast<Eigen::Index>(i)];
  return left;
}

void NewmarkWindow::refuse_unbalanced(std::int64_t window, int improvements, const Eigen::VectorXd& left) const {
  Eigen::Index worst = 0;
  left.cwiseAbs().maxCoeff(&worst);
  std::size_t part = parts_.size() - 1;
  while (worst < parts_.offsets[part]) --part;
  const auto& state = parts_.states[part];
  const auto node = static_cast<std::size_t>(worst - parts_.offsets[part]) /
                    static_cast<std::size_t>(fem::components(state.part.mesh.model));
  throw SolverError(
      fmt::format("window {}: Newton's iteration does not settle: after {} steps {:.3g} N are out of balance at node "
                  "{} of body '{}' "
                  "{}, where {:g} of the largest force would do; use a smaller time.step_s",
                  window, improvements, std::abs(left[worst]), state.part.body_node[node], state.name,
                  fem::place_text(state.part.mesh.model, state.part.mesh.position[node]), balanced_share));
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
  linearised_at_ = trial_linearised_at_;
  if (contact_) contact_->account(parts_.states, trial.increment, mean_velocity_);
}

}  // namespace ricochet::implicit_solver
