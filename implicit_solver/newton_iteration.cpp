#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/mesh.hpp"
#include "implicit_solver/newmark_window.hpp"

// Newton's iteration of a window whose elements are not linear and hold nothing that would make it so.

namespace ricochet::implicit_solver {

namespace {
/// Newton's iteration ends when what is out of balance is so much of the largest force, or when that or an improvement
/// is what the rounding of displacements makes: of u, of its increment, of the size of a part that turns; or what the
/// contact's forces are not known to.
constexpr double balanced_share = 1e-10, rounding_share = 4.0 * std::numeric_limits<double>::epsilon();
/// Improvements by one tangent go on while each leaves no more than so much of what was out of balance: ten solves then
/// take it from 1 to 1e-7, and a factorisation costs more than ten.
constexpr double slow_share = 0.2;
constexpr int most_improvements = 50;
/// Steps that are remembered, a vector each.
constexpr std::size_t most_steps = 50;
/// Where they would lengthen a step by more, they are forgotten.
constexpr double most_growth = 1e4;
/// An improvement that goes too far is shortened until the slope of the window's potential along it is so much of what
/// it was at its beginning, or less.
constexpr double level_share = 0.1;
constexpr int most_shortenings = 20;
/// The operator may point so far beside a part that turns [rad]. Each step of the iteration leaves about so much of
/// what is out of balance: two settle most windows. Each turn costs the contact a new compliance.
constexpr double most_beside = 1e-4;
/// A turn by less does not help.
constexpr double least_turn = 1e-8;

/// The angle of the rotation from one to the other, or twice the sine of its half [rad].
double angle_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  return (to - from).norm() / std::numbers::sqrt2;
}
}  // namespace

/// Where parts that turn get to if they move on as they are, and what is out of balance there.
void NewmarkWindow::begin_balance(WindowTrial& trial) {
  std::vector<fem::RigidMotion> begin, end;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const auto& state = parts_.states[b];
    parts_.segment(newton_.predicted, b).setZero();
    begin.emplace_back();
    end.emplace_back();
    if (!state.frame) continue;
    newton_.before = state.u + dt_ * state.v;
    begin.back() = state.frame->fit(state.u, state.parallel.get()).motion;
    end.back() = state.frame->fit(newton_.before, state.parallel.get()).motion;
    const Eigen::Matrix3d turn = end.back().rotation * begin.back().rotation.transpose();
    auto predicted = parts_.segment(newton_.predicted, b);
    const int components = fem::components(state.part.mesh.model);
    for (int node = 0; node < state.part.nodes(); ++node) {
      Eigen::Vector3d place = state.part.mesh.position[static_cast<std::size_t>(node)] - begin.back().to_m;
      for (int c = 0; c < components; ++c) place[c] += state.u[node * components + c];
      // By differences, not RigidMotion::displacement: the rounding of places would move a body at rest.
      const Eigen::Vector3d moved = (turn * place - place) + (end.back().to_m - begin.back().to_m);
      for (int c = 0; c < components; ++c) predicted[node * components + c] = moved[c];
    }
  }
  if (solver_.may_turn()) turn_ahead(begin, end);
  newton_.before = newton_.predicted;
  for (std::size_t b = 0; b < parts_.size(); ++b)
    for (const auto& c : parts_.states[b].constrained)
      newton_.before[parts_.offsets[b] + c.dof] = trial.increment[parts_.offsets[b] + c.dof];
  find_imbalance(newton_.before, trial.end.external, newton_.no_link);
  rhs_ = 0.25 * dt_ * dt_ * newton_.imbalance;
  solver_.eliminate(rhs_);
}

/// The operator turns when it has come to point too far beside a part, by as much again ahead of it: it serves until
/// the part has passed it.
void NewmarkWindow::turn_ahead(const std::vector<fem::RigidMotion>& begin, const std::vector<fem::RigidMotion>& end) {
  std::vector<Eigen::Matrix3d> directions = accepted_.directions;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (!parts_.states[b].frame) continue;
    const Eigen::Matrix3d& now = end[b].rotation;
    const double beside = angle_between(directions[b], now), in_window = angle_between(begin[b].rotation, now);
    if (beside <= most_beside) continue;
    directions[b] = now;
    const Eigen::Matrix3d turn = now * begin[b].rotation.transpose();
    const Eigen::Vector3d axis(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
    if (in_window > least_turn && in_window < most_beside)
      directions[b] = Eigen::AngleAxisd(most_beside, axis.normalized()).toRotationMatrix() * now;
  }
  if (solver_.directions() != directions) solver_.turn(directions);
}

/// Turns the operator to the directions at a displacement; false if it has them.
bool NewmarkWindow::turn_to(const Eigen::VectorXd& u) {
  const std::vector<Eigen::Matrix3d> directions = parts_.rotations(u);
  bool other = false;
  for (std::size_t b = 0; b < directions.size(); ++b)
    other = other || angle_between(solver_.directions()[b], directions[b]) > least_turn;
  if (other && solver_.may_turn()) solver_.turn(directions);
  return other && solver_.may_turn();
}

/// Newton's iteration where the elements are not linear: each step is a linear window for what the last one left out of
/// balance, with contact forces found anew. The operator stays while it serves, and what its steps have shown of the
/// difference to the tangent mends the next ones.
void NewmarkWindow::balance(std::int64_t window, WindowTrial& trial) {
  const double quarter = 0.25 * dt_ * dt_;
  double before_n = std::numeric_limits<double>::infinity(), largest_n = find_imbalance(trial);
  steps_.clear();
  for (int improvements = 0;; ++improvements) {
    const Eigen::VectorXd left = imbalance_with_contact();
    const double left_n = left.lpNorm<Eigen::Infinity>();
    double moved_m = 0.0;
    if (is_balanced(left, largest_n, trial, moved_m)) break;
    if (!std::isfinite(left_n) &&
        !steps_.empty()) {  // mended too far: from the last place again, by the operator alone
      steps_.clear();
      trial.increment = newton_.before;
      largest_n = find_imbalance(trial);
      continue;
    }
    if (improvements == most_improvements || !std::isfinite(left_n)) refuse_unbalanced(window, improvements, left);
    if (left_n > slow_share * before_n) {
      const Eigen::VectorXd u = parts_.displacement() + trial.increment;
      if (!turn_to(u)) solver_.linearise(u);
      steps_.clear();
    }
    before_n = left_n;
    newton_.before = trial.increment;
    rhs_ = quarter * newton_.imbalance;
    solver_.improve(rhs_, trial.increment);
    Eigen::VectorXd step = trial.increment - newton_.before;
    mend(step);
    trial.increment = newton_.before + step;
    largest_n = find_imbalance(trial);
    if (shorten(step, trial, largest_n)) {
      steps_.clear();
    } else {
      remember(std::move(step));
    }
    if ((trial.increment - newton_.before).lpNorm<Eigen::Infinity>() <= rounding_share * moved_m) break;
  }
  tried_ = {solver_.linearised_at(), solver_.directions()};
  forget();  // rhs_ is another
}

/// By the rounding of each part alone: a stiff one says nothing of what its partner may leave. `moved_m`: the largest
/// number that is rounded.
bool NewmarkWindow::is_balanced(const Eigen::VectorXd& left, double largest_n, const WindowTrial& trial,
                                double& moved_m) const {
  bool balanced = true;
  const double uncertain_n = contact_ ? contact_->uncertain_force() : 0.0;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (parts_.states[b].part.dofs() == 0) continue;
    const double own_m = std::max({parts_.states[b].u.lpNorm<Eigen::Infinity>(),
                                   parts_.segment(trial.increment, b).lpNorm<Eigen::Infinity>(), parts_.turning_m(b)});
    const double rounded_n = rounding_share * own_m * solver_.stiffest_n_m(b);
    balanced = balanced && parts_.segment(left, b).lpNorm<Eigen::Infinity>() <=
                               std::max({balanced_share * largest_n, rounded_n, uncertain_n});
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

void NewmarkWindow::remember(Eigen::VectorXd step) {
  if (steps_.size() == most_steps) steps_.clear();
  steps_.push_back(std::move(step));
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
  double low = 0.0, at_low = first, high = 1.0, at_high = newton_.imbalance.dot(step) + by_contact;
  if (!(first > 0.0) || !(at_high < -0.5 * first)) return false;
  double share = 1.0, slope = at_high;
  for (int k = 0; k < most_shortenings && std::abs(slope) > level_share * first; ++k) {
    share = k % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
    trial.increment = newton_.before + share * step;
    largest_n = find_imbalance(trial);
    slope = newton_.imbalance.dot(step) + by_contact;
    (slope > 0.0 ? low : high) = share;
    (slope > 0.0 ? at_low : at_high) = slope;
  }
  return true;
}

/// f - P - L - M a* at the free dofs for the present increment, without contact forces. Returns the largest of the
/// forces.
double NewmarkWindow::find_imbalance(const WindowTrial& trial) {
  return find_imbalance(trial.increment, trial.end.external, trial.end.link);
}

double NewmarkWindow::find_imbalance(const Eigen::VectorXd& increment, const Eigen::VectorXd& external,
                                     const Eigen::VectorXd& link) {
  const double dt = dt_;
  double largest = 0.0;
  newton_.link = link;
  add_interface_force_of(increment, newton_.link);
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    const auto& state = parts_.states[b];
    const auto du = parts_.segment(increment, b);
    parts_.evaluate_moved(dt_, b, increment, newton_.internal);
    newton_.inertia = state.mass.cwiseProduct((4.0 / (dt * dt)) * (du - dt * state.v) - state.a);
    auto left = parts_.segment(newton_.imbalance, b);
    left = parts_.segment(external, b);
    for (std::size_t i = 0; i < state.dashpots.size(); ++i) {
      const auto& d = state.dashpots[i];
      left[d.dof] = dashpot_load_[b][i] + d.force(2.0 / dt * du[d.dof] - state.v[d.dof]);
    }
    left -= parts_.segment(newton_.link, b);
    for (int dof = 0; dof < state.part.dofs(); ++dof) {
      if (!state.free[static_cast<std::size_t>(dof)]) left[dof] = newton_.internal[dof] = newton_.inertia[dof] = 0.0;
    }
    for (const double n : {left.lpNorm<Eigen::Infinity>(), newton_.internal.lpNorm<Eigen::Infinity>(),
                           newton_.inertia.lpNorm<Eigen::Infinity>()})
      largest = std::max(largest, n);
    left -= newton_.internal + newton_.inertia;
  }
  return largest;
}

Eigen::VectorXd NewmarkWindow::imbalance_with_contact() const {
  Eigen::VectorXd left = newton_.imbalance;
  for (std::size_t i = 0; i < roots_.size(); ++i)
    left[roots_[i].dof] += contact_->kappa() * contact_->root_force()[static_cast<Eigen::Index>(i)];
  return left;
}

void NewmarkWindow::refuse_unbalanced(std::int64_t window, int improvements, const Eigen::VectorXd& left) const {
  Eigen::Index worst = 0;
  left.cwiseAbs().maxCoeff(&worst);
  const std::size_t part = parts_.part_of(worst);
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

}  // namespace ricochet::implicit_solver
