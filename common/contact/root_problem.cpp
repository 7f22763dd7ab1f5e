#include "common/contact/root_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/contact/friction.hpp"

namespace ricochet::solver {

namespace {
constexpr int most_newton_steps = 30;
/// How often all wrong states may change without becoming fewer, and how often the last of them alone.
constexpr int chances_of_all = 3, most_alone = 100;
constexpr int most_sweeps_of_fallback = 5000;
constexpr int sweeps_before_newton = most_sweeps / 5;
/// Share of what a pair yields by which it gives way besides, where sweeps did not settle: where nodes hang rows may
/// depend on each other, and their forces would be anything.
constexpr double softness = 1e-11;
constexpr double round_off = 1e-12;
/// Share of a pair's yielding along its normal: less along its tangent is round-off squared in its row. Supports hold
/// it, as at an axis that nodes of a divided mesh miss by 1e-19 m.
constexpr double held_along = round_off * round_off;
/// Change of force by which Newton's method has settled where its rows turn.
constexpr double settled_step = 1e-11;
/// Largest residual that a run goes on with; from `converged_contact_residual` on it is counted.
constexpr double residual_to_stop = 1e-3;
/// Residual that round-off leaves; above, another method tries.
constexpr double converged_residual = 1e-10;
}  // namespace

RootProblem::RootProblem(const scene::Contact& law, Compliance compliance, const std::vector<PairLaw>& pairs, double dt)
    : projection_(law, dt),
      directions_(pairs.empty() ? 1 : static_cast<int>(compliance.size() / std::ssize(pairs))),
      compliance_(std::move(compliance)),
      rows_(pairs.size()),
      motion_(compliance_.size()) {
  for (const auto& pair : pairs) blocks_.push_back({.friction_coefficient = pair.friction_coefficient});
  for (int i = 0; i < this->pairs(); ++i) {
    const auto& pair = pairs[static_cast<std::size_t>(i)];
    auto& block = blocks_[static_cast<std::size_t>(i)];
    if (law.enforcement == scene::Enforcement::penalty) block.slack = 1.0 / (law.penalty_pa_m * pair.area_m2);
    block.normal = compliance_.alone(i) + block.slack;
    if (pair.friction_coefficient == 0.0) continue;
    for (int d = 1; d < directions_; ++d) {
      const double along = compliance_.alone(unknown(i, d));
      if (along > held_along * block.normal) block.along(d - 1, d - 1) = along;
    }
    if (directions_ == 3 && compliance_.has_columns() && block.slides(0) && block.slides(1))
      block.along(0, 1) = block.along(1, 0) = compliance_.entry(unknown(i, 1), unknown(i, 2));
  }
  solution_ = open();
}

RootProblem::Solution RootProblem::open() const {
  return {Eigen::VectorXd::Zero(compliance_.size()), std::vector<ContactState>(blocks_.size(), ContactState::open), 0,
          0.0};
}

Eigen::Vector3d RootProblem::of_pair(int pair, const Eigen::VectorXd& x) const {
  Eigen::Vector3d of(0.0, 0.0, 0.0);
  for (int d = 0; d < directions_; ++d) of[d] = x[unknown(pair, d)];
  return of;
}

PairWindow RootProblem::window_of(int pair, const Window& window) const {
  PairWindow of{.gap_free = window.gap_free[pair]};
  for (int d = 1; d < directions_; ++d) {
    of.slip_free[d - 1] = window.slip_free[unknown(pair, d - 1)];
    of.slip_velocity[d - 1] = window.slip_velocity[unknown(pair, d - 1)];
    of.last[d - 1] = window.last[unknown(pair, d)];
  }
  return of;
}

const RootProblem::Solution& RootProblem::solve(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                                const Eigen::VectorXd& slip_velocity, const Solution& last,
                                                const Solution* from) {
  const Window window{gap_free, slip_free, slip_velocity, last.force};
  const Solution& start = from ? *from : last;
  solution_.force = start.force;
  solution_.states = start.states;
  solution_.iterations = 0;
  newton(window);
  solution_.residual = residual(window);
  if (!solution_.force.allFinite() || solution_.residual > converged_residual) {
    start_nearer(window, start);
    fall_back(window);
  }
  if (solution_.residual > residual_to_stop) {
    solution_.force = last.force;
    fall_back(window);
  }
  finish();
  return solution_;
}

/// The matrix of a node that two contacts hold along one direction is singular, or so but for rounding, as that of rows
/// that depend on each other where nodes hang: Newton's forces are not numbers, or nowhere near. Sweeps begin where it
/// began, if that is nearer.
void RootProblem::start_nearer(const Window& window, const Solution& start) {
  const double violation_n = violation(window);
  std::swap(solution_.force, before_);
  solution_.force = start.force;
  compliance_.times(solution_.force, motion_);
  if (before_.allFinite() && violation_n <= violation(window)) std::swap(solution_.force, before_);
}

/// Sweeps and, where these stay above round-off, Newton's method from there. With friction few sweeps lead it nowhere,
/// and softness (measured) away.
void RootProblem::fall_back(const Window& window) {
  const bool friction = rubs();
  const int first = friction ? most_sweeps_of_fallback : sweeps_before_newton;
  for (const int most : {first, most_sweeps_of_fallback - first}) {
    if (most == 0) return;
    gauss_seidel(window, most);
    solution_.residual = residual(window);
    if (solution_.residual <= converged_residual) return;
    go_on_by_newton(window, friction ? 0.0 : softness);
    if (solution_.residual <= converged_residual) return;
  }
}

/// From forces that sweeps have found, which stay unless it comes nearer.
void RootProblem::go_on_by_newton(const Window& window, double soft) {
  Solution swept = solution_;
  const double violation_n = violation(window);
  newton(window, soft);
  if (solution_.force.allFinite() && violation(window) <= violation_n) {
    solution_.residual = residual(window);
    return;
  }
  swept.iterations = solution_.iterations;
  solution_ = std::move(swept);
}

/// From the present forces and states, until neither changes; for a stated number of times. Without friction this is
/// block principal pivoting (Júdice and Pires 1994): where all states that are wrong change at once and do not become
/// fewer, the last of them changes alone until they do. With steps enough that ends for every positive definite D.
void RootProblem::newton(const Window& window, double soft) {
  const bool friction = rubs();
  int fewest = pairs() + 1, chances = chances_of_all;
  const auto turns = [this](ContactState s) { return s != ContactState::open && projection_.turns(s); };
  if (directions_ > 1 && std::any_of(solution_.states.begin(), solution_.states.end(), turns))
    compliance_.times(solution_.force, motion_);
  const int most = most_newton_steps + (friction ? 0 : std::min(pairs(), most_alone));
  for (int n = 0; n < most; ++n, ++solution_.iterations) {
    if (!find_rows(window, soft) && n > 0) return;
    before_ = solution_.force;
    if (std::all_of(rows_.begin(), rows_.end(), [](const PairRows& rows) { return rows.idle(0); })) {
      solution_.force.setZero();
    } else {
      system_.solve(compliance_, rows_, solution_.force);
    }
    const int wrong = update_states(window, friction || chances > 0);
    chances = wrong < fewest ? chances_of_all : chances - 1;
    fewest = std::min(fewest, wrong);
    const double step = (solution_.force - before_).cwiseAbs().maxCoeff();
    if (wrong == 0 && step <= settled_step * solution_.force.cwiseAbs().maxCoeff()) return;
  }
}

/// Returns whether any has changed.
bool RootProblem::find_rows(const Window& window, double soft) {
  bool changed = false;
  for (int i = 0; i < pairs(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    PairRows rows = projection_.rows(blocks_[k], window_of(i, window), of_pair(i, solution_.force), of_pair(i, motion_),
                                     solution_.states[k]);
    if (solution_.states[k] != ContactState::open) rows.own(0, 0) += soft;
    changed = changed || !(rows == rows_[k]);
    rows_[k] = rows;
  }
  return changed;
}

/// Returns how many were not what the criteria ask for. All of them change, or the last alone.
int RootProblem::update_states(const Window& window, bool all) {
  compliance_.times(solution_.force, motion_);
  const double negligible_n = round_off * solution_.force.head(pairs()).cwiseAbs().maxCoeff();
  const double negligible_m = round_off * window.gap_free.cwiseAbs().maxCoeff();
  int wrong = 0;
  for (int i = pairs() - 1; i >= 0; --i) {
    const auto k = static_cast<std::size_t>(i);
    auto& state = solution_.states[k];
    const ContactState next = projection_.next_state(blocks_[k], window_of(i, window), of_pair(i, solution_.force),
                                                     of_pair(i, motion_), state, negligible_n, negligible_m);
    if (next == state) continue;
    if (all || wrong == 0) state = next;
    ++wrong;
  }
  return wrong;
}

/// Slow, but without friction it cannot cycle, and with little of it it does not.
void RootProblem::gauss_seidel(const Window& window, int most) {
  auto& x = solution_.force;
  compliance_.times(x, motion_);
  const auto project = [&](int i, const auto& set) {
    const auto& block = blocks_[static_cast<std::size_t>(i)];
    const PairWindow of = window_of(i, window);
    set(i, Projection::normal(block, of, x[i], motion_[i]));
    if (!block.slides()) return;
    const Eigen::Vector2d along = projection_.tangential(block, of, of_pair(i, x), of_pair(i, motion_));
    for (int d = 1; d < directions_; ++d) set(unknown(i, d), along[d - 1]);
  };
  solution_.iterations += sweep(compliance_, pairs(), most, x, motion_, project).sweeps;
  compliance_.times(x, motion_);
  states_of_forces();
}

const RootProblem::Solution& RootProblem::sweep_from_none(const Eigen::VectorXd& gap_free,
                                                          const Eigen::VectorXd& slip_free,
                                                          const Eigen::VectorXd& normal, bool held) {
  auto& x = solution_.force;
  x.setZero();
  if (normal.size() > 0) x.head(pairs()) = normal;
  compliance_.times(x, motion_);
  before_.setZero(x.size());
  const Window window{gap_free, slip_free, before_, before_};
  const auto project = [&](int i, const auto& set) {
    const auto& block = blocks_[static_cast<std::size_t>(i)];
    const PairWindow of = window_of(i, window);
    if (normal.size() == 0 && block.normal > 0.0) {
      const double free = of.gap_free + motion_[i];
      set(i, held ? x[i] - free / block.normal : Projection::normal(block, of, x[i], motion_[i]));
    }
    if (!block.slides()) return;
    const Eigen::Vector3d force = of_pair(i, x), moved = of_pair(i, motion_);
    const Eigen::Vector2d along =
        held ? Eigen::Vector2d(force.tail<2>() + holding_of_pair(block.along, of.slip_free + moved.tail<2>()))
             : projection_.tangential(block, of, force, moved);
    for (int d = 1; d < directions_; ++d) set(unknown(i, d), along[d - 1]);
  };
  solution_.iterations = 0;
  for (const int most : {sweeps_before_newton, most_sweeps - sweeps_before_newton}) {
    const Swept swept = sweep(compliance_, pairs(), most, x, motion_, project);
    solution_.iterations += swept.sweeps;
    solution_.residual = swept.residual;
    states_of_forces();
    if (swept.residual <= settled_share) break;
    if (held || normal.size() > 0) continue;  // Newton's method finds all forces, by their signs
    solution_.residual = residual(window);
    go_on_by_newton(window, softness);
    if (solution_.residual <= converged_residual) break;
    compliance_.times(x, motion_);
  }
  if (held) {
    std::fill(solution_.states.begin(), solution_.states.end(), ContactState::stick);
  } else {
    finish();
  }
  return solution_;
}

const RootProblem::Solution& RootProblem::hold(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free) {
  std::fill(solution_.states.begin(), solution_.states.end(), ContactState::stick);
  before_.setZero(compliance_.size());
  const Window window{gap_free, slip_free, slip_free, before_};
  for (int i = 0; i < pairs(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    rows_[k] = Projection::held_rows(blocks_[k], window_of(i, window));
  }
  system_.solve(compliance_, rows_, solution_.force);
  solution_.iterations = 1;
  solution_.residual = 0.0;
  finish();
  return solution_;
}

const RootProblem::Solution& RootProblem::spring(const Eigen::VectorXd& gap, const Eigen::VectorXd& slip) {
  std::fill(solution_.states.begin(), solution_.states.end(), ContactState::stick);
  solution_.force.setZero();
  for (int i = 0; i < pairs(); ++i) {
    const auto& block = blocks_[static_cast<std::size_t>(i)];
    if (block.slack == 0.0) continue;
    solution_.force[i] = -gap[i] / block.slack;
    for (int d = 1; d < directions_; ++d)
      if (block.slides(d - 1)) solution_.force[unknown(i, d)] = -slip[unknown(i, d - 1)] / block.slack;
  }
  finish();
  return solution_;
}

bool RootProblem::rubs() const {
  return std::any_of(blocks_.begin(), blocks_.end(), [](const PairBlock& block) { return block.slides(); });
}

void RootProblem::states_of_forces() {
  for (int i = 0; i < pairs(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    solution_.states[k] = projection_.state_of(blocks_[k], of_pair(i, solution_.force));
  }
}

/// With `motion_` = D x of the present forces, the largest change of force that would mend a condition alone [N].
double RootProblem::violation(const Window& window) const {
  const auto& x = solution_.force;
  double largest = 0.0;
  for (int i = 0; i < pairs(); ++i) {
    const auto& block = blocks_[static_cast<std::size_t>(i)];
    const PairWindow of = window_of(i, window);
    largest = std::max(largest, std::abs(x[i] - Projection::normal(block, of, x[i], motion_[i])));
    if (!block.slides()) continue;
    const Eigen::Vector3d force = of_pair(i, x);
    const Eigen::Vector2d right = projection_.tangential(block, of, force, of_pair(i, motion_));
    largest = std::max(largest, (force.tail<2>() - right).norm());
  }
  return largest;
}

double RootProblem::residual(const Window& window) const {
  const double largest = violation(window), scale = solution_.force.head(pairs()).maxCoeff();
  return scale > 0.0 ? largest / scale : largest > 0.0 ? 1.0 : 0.0;
}

/// An open pair has no force (those found may be of states before), and one with friction that supports hold sticks.
void RootProblem::finish() {
  for (int i = 0; i < pairs(); ++i) {
    const auto& block = blocks_[static_cast<std::size_t>(i)];
    auto& state = solution_.states[static_cast<std::size_t>(i)];
    if (state == ContactState::open) {
      for (int d = 0; d < directions_; ++d) solution_.force[unknown(i, d)] = 0.0;
    } else if (!block.slides()) {
      state = directions_ > 1 && block.friction_coefficient > 0.0 ? ContactState::stick : ContactState::slip;
    }
  }
}

void require_solved(const RootProblem::Solution& solution) {
  if (solution.residual <= residual_to_stop) return;
  throw SolverError(
      fmt::format("the forces of {} contact pairs were not found: after {} iterations their conditions are violated by "
                  "{:.2g} of the largest "
                  "force, allowed: {:.0e}; use a smaller time.step_s, contact.friction_coefficient or "
                  "contact.friction_regularisation_s_m",
                  solution.states.size(), solution.iterations, solution.residual, residual_to_stop));
}

}  // namespace ricochet::solver
