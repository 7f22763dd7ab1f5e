#include "common/solver/root_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/solver/friction.hpp"

namespace ricochet::solver {

namespace {
constexpr int max_state_iterations = 30;
constexpr double round_off = 1e-12;
/// Largest residual that a run goes on with; from `converged_contact_residual` on it is counted.
constexpr double residual_to_stop = 1e-3;
/// Residual that round-off leaves; above, another method tries.
constexpr double converged_residual = 1e-10;
}  // namespace

RootProblem::RootProblem(const scene::Contact& law, Compliance compliance, std::vector<PairLaw> pairs, double dt)
    : law_(law),
      pair_laws_(std::move(pairs)),
      regularised_(law.friction_law == scene::FrictionLaw::regularised),
      pairs_(static_cast<int>(pair_laws_.size())),
      friction_(compliance.size() > pairs_),
      cone_(friction_ && compliance.size() == Eigen::Index{3} * pairs_),
      dt_(dt),
      compliance_(std::move(compliance)),
      place_(static_cast<std::size_t>(compliance_.size()), -1),
      states_(static_cast<std::size_t>(pairs_)),
      rhs_(compliance_.size()),
      motion_(compliance_.size()),
      slip_slope_(Eigen::VectorXd::Zero(pairs_)),
      cone_slope_(Eigen::VectorXd::Zero(pairs_)),
      solution_(open()) {
  involved_.reserve(place_.size());
  if (!cone_) return;
  cone_rows_.resize(pair_laws_.size());
  for (int i = 0; i < pairs_; ++i) {
    const int t = pairs_ + i, b = 2 * pairs_ + i;
    auto& block = block_.emplace_back(Eigen::Matrix2d::Zero());
    block.diagonal() << compliance_.alone(t), compliance_.alone(b);
    if (compliance_.has_rows()) block(0, 1) = block(1, 0) = compliance_.entry(t, b);
  }
}

RootProblem::Solution RootProblem::open() const {
  return {Eigen::VectorXd::Zero(compliance_.size()),
          std::vector<ContactState>(static_cast<std::size_t>(pairs_), ContactState::open), 0, 0.0};
}

double RootProblem::slack(int pair) const {
  if (law_.enforcement != scene::Enforcement::penalty) return 0.0;
  return 1.0 / (law_.penalty_pa_m * pair_laws_[static_cast<std::size_t>(pair)].area_m2);
}

double RootProblem::alone(int unknown) const { return compliance_.alone(unknown) + slack(unknown % pairs_); }

void RootProblem::start_from(const Solution& last) {
  for (int i = 0; i < pairs_; ++i) {
    auto& state = states_[static_cast<std::size_t>(i)];
    const ContactState before = last.states[static_cast<std::size_t>(i)];
    state.closed = before != ContactState::open;
    state.tangent = Tangent::none;
    if (!state.closed || held(i)) continue;
    const bool plus = last.force[pairs_ + i] > 0.0;
    state.tangent = regularised_                    ? Tangent::regularised
                    : before == ContactState::stick ? Tangent::stick
                    : cone_                         ? Tangent::slip
                    : plus                          ? Tangent::slip_plus
                                                    : Tangent::slip_minus;
  }
}

bool RootProblem::held(int pair) const {
  return !friction_ || friction_of(pair) == 0.0 ||
         (compliance_.alone(pairs_ + pair) <= 0.0 && (!cone_ || block_[static_cast<std::size_t>(pair)](1, 1) <= 0.0));
}

void RootProblem::solve_linear(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                               const Eigen::VectorXd& slip_velocity, const Solution& last) {
  if (cone_) find_cone_rows(slip_free, slip_velocity, last);
  rhs_.setZero();
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    if (!state.closed) continue;
    rhs_[i] = -gap_free[i] / alone(i);
    if (!friction_ || cone_) continue;
    const int t = pairs_ + i;
    if (state.tangent == Tangent::stick) rhs_[t] = (slack(i) * last.force[t] - slip_free[i]) / alone(t);
    if (state.tangent != Tangent::regularised) continue;
    // tau + mu lambda tanh(xi v(x)) = 0, linearised about v0: v of the present x; or 0, where tanh is steepest and
    // Newton's method cannot overshoot, if the present tau turns the slip around. dv/dslip = 2/dt
    const double xi = law_.friction_regularisation_s_m, mu = friction_of(i);
    const double slipped = motion_[t];
    const double velocity = 2.0 * (slip_free[i] + slipped) / dt_ - slip_velocity[i];
    const double without = velocity - 2.0 / dt_ * compliance_.alone(t) * solution_.force[t];
    const double about = velocity * without < 0.0 ? 0.0 : velocity;
    const double tanh = std::tanh(xi * about);
    slip_slope_[i] = mu * std::max(0.0, solution_.force[i]) * xi * (1.0 - tanh * tanh) * 2.0 / dt_;
    cone_slope_[i] = mu * tanh;
    rhs_[t] = slip_slope_[i] * (slipped - 0.5 * dt_ * (velocity - about));
  }
  if (cone_) cone_right_hand_side();
  solve_states();
}

bool RootProblem::update_states(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                const Solution& last) {
  compliance_.times(solution_.force, motion_);
  const double force_scale = round_off * solution_.force.head(pairs_).cwiseAbs().maxCoeff();
  const double gap_scale = round_off * gap_free.cwiseAbs().maxCoeff();
  bool changed = false;
  for (int i = 0; i < pairs_; ++i) {
    auto& state = states_[static_cast<std::size_t>(i)];
    const PairState before = state;
    const double normal = solution_.force[i], mu = friction_of(i);
    if (state.closed && normal < -force_scale) {
      state = {};
    } else if (!state.closed && gap_free[i] + motion_[i] < -gap_scale) {
      state.closed = true;
      // Of solids a pair that closes is first given mu times its force, against its slip: held, it may be torn open
      // again.
      if (!held(i)) state.tangent = regularised_ ? Tangent::regularised : cone_ ? Tangent::slip : Tangent::stick;
    } else if (state.closed && !held(i) && cone_ && !regularised_) {
      const double outside = reach(i, slip_free, last).norm() - mu * normal;
      if (std::abs(outside) > force_scale) state.tangent = outside > 0.0 ? Tangent::slip : Tangent::stick;
    } else if (state.closed && !held(i) && !regularised_) {
      const double tangential = solution_.force[pairs_ + i];
      const double slip = slip_free[i] + motion_[pairs_ + i];
      if (state.tangent == Tangent::stick && std::abs(tangential) > mu * normal + force_scale) {
        state.tangent = tangential > 0.0 ? Tangent::slip_plus : Tangent::slip_minus;
      } else if ((state.tangent == Tangent::slip_plus && slip > 0.0) ||
                 (state.tangent == Tangent::slip_minus && slip < 0.0)) {
        state.tangent = Tangent::stick;  // the traction must oppose the slip
      }
    }
    changed |= !(state == before);
  }
  return changed;
}

const RootProblem::Solution& RootProblem::solve(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                                const Eigen::VectorXd& slip_velocity, const Solution& last) {
  start_from(last);
  solution_.force = last.force;
  solution_.iterations = 0;
  if (turns()) compliance_.times(solution_.force, motion_);
  find_states(gap_free, slip_free, slip_velocity, last);
  // Of a node that two contacts hold along one direction the matrix is singular; sweeps do not mind.
  if (!solution_.force.allFinite()) {
    solution_.force = last.force;
    compliance_.times(solution_.force, motion_);
  }
  solution_.residual = residual(gap_free, slip_free, slip_velocity, last);
  if (solution_.residual > converged_residual) {
    solution_.iterations += sweep(gap_free, slip_free, slip_velocity, last);
    compliance_.times(solution_.force, motion_);
    solution_.residual = residual(gap_free, slip_free, slip_velocity, last);
  }
  if (solution_.residual > converged_residual && compliance_.has_rows() &&
      (cone_ || (!regularised_ && compliance_.dense()))) {
    const Eigen::VectorXd swept = solution_.force;
    const double of_sweeps = solution_.residual;
    if (cone_) {
      find_states(gap_free, slip_free, slip_velocity, last);
    } else {
      solution_.iterations += lemke(gap_free, slip_free, last);
      compliance_.times(solution_.force, motion_);
    }
    solution_.residual = residual(gap_free, slip_free, slip_velocity, last);
    if (!(solution_.residual <= of_sweeps)) {
      solution_.force = swept;
      states_of_forces();
      solution_.residual = of_sweeps;
    }
  }
  finish();
  return solution_;
}

/// From the present states and forces, until neither changes; for a stated number of times. Where rows turn, `motion_`
/// is D x of the forces from the start on.
void RootProblem::find_states(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                              const Eigen::VectorXd& slip_velocity, const Solution& last) {
  bool settled = false;
  for (int n = 0; !settled && n < max_state_iterations; ++n, ++solution_.iterations) {
    before_ = solution_.force;
    const bool any = std::any_of(states_.begin(), states_.end(), [](const PairState& s) { return s.closed; });
    if (any) {
      solve_linear(gap_free, slip_free, slip_velocity, last);
    } else {
      solution_.force.setZero();
    }
    const bool changed = update_states(gap_free, slip_free, last);
    const double step = (solution_.force - before_).cwiseAbs().maxCoeff();
    settled = !changed && (!turns() || step <= 1e-11 * solution_.force.cwiseAbs().maxCoeff());
  }
}

void RootProblem::stick_all() {
  for (int i = 0; i < pairs_; ++i) {
    states_[static_cast<std::size_t>(i)] = {.closed = true, .tangent = held(i) ? Tangent::none : Tangent::stick};
  }
}

const RootProblem::Solution& RootProblem::hold(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free) {
  stick_all();
  rhs_.setZero();
  for (int i = 0; i < pairs_; ++i) {
    rhs_[i] = -gap_free[i] / alone(i);
    if (!held(i) && !cone_) rhs_[pairs_ + i] = -slip_free[i] / alone(pairs_ + i);
  }
  if (cone_) {
    find_cone_rows(slip_free, slip_free, open());
    cone_right_hand_side();
  }
  solve_states();
  solution_.iterations = 1;
  solution_.residual = 0.0;
  finish();
  return solution_;
}

const RootProblem::Solution& RootProblem::spring(const Eigen::VectorXd& gap, const Eigen::VectorXd& slip) {
  stick_all();
  solution_.force.setZero();
  for (int i = 0; i < pairs_ && law_.enforcement == scene::Enforcement::penalty; ++i) {
    solution_.force[i] = -gap[i] / slack(i);
    if (!held(i)) solution_.force[pairs_ + i] = -slip[i] / slack(i);
    if (!held(i) && cone_) solution_.force[2 * pairs_ + i] = -slip[pairs_ + i] / slack(i);
  }
  finish();
  return solution_;
}

double RootProblem::tangential_alone(int pair, double slip, double slip_velocity, double last) const {
  const int t = pairs_ + pair;
  // A pair that is about to open may pull by what round-off leaves.
  const double force = solution_.force[t], limit = friction_of(pair) * std::max(0.0, solution_.force[pair]);
  if (!regularised_) return std::clamp(force - (slip + slack(pair) * (force - last)) / alone(t), -limit, limit);
  const double rate = 2.0 / dt_ * compliance_.alone(t), free_rate = 2.0 / dt_ * slip - slip_velocity - rate * force;
  return friction_of_pair(law_, limit, free_rate, -free_rate / rate);
}

void RootProblem::states_of_forces() {
  const auto& x = solution_.force;
  for (int i = 0; i < pairs_; ++i) {
    auto& state = states_[static_cast<std::size_t>(i)];
    state = {.closed = x[i] > 0.0, .tangent = Tangent::none};
    if (!state.closed || held(i)) continue;
    if (cone_ && !regularised_) {
      const double limit = friction_of(i) * x[i] * (1.0 - round_off);
      state.tangent = along(i, x).norm() < limit ? Tangent::stick : Tangent::slip;
      continue;
    }
    const double tangential = x[pairs_ + i], limit = friction_of(i) * x[i];
    state.tangent = regularised_                                       ? Tangent::regularised
                    : std::abs(tangential) < limit * (1.0 - round_off) ? Tangent::stick
                    : tangential > 0.0                                 ? Tangent::slip_plus
                                                                       : Tangent::slip_minus;
  }
}

double RootProblem::residual(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                             const Eigen::VectorXd& slip_velocity, const Solution& last) {
  const auto& x = solution_.force;
  double largest = 0.0;
  for (int i = 0; i < pairs_; ++i) {
    const double gap = gap_free[i] + motion_[i] + slack(i) * x[i];
    largest = std::max(largest, std::abs(x[i] - std::max(0.0, x[i] - gap / alone(i))));
    if (held(i)) continue;
    if (cone_) {
      largest = std::max(largest, (along(i, x) - cone_alone(i, slip_free, slip_velocity, last)).norm());
      continue;
    }
    const int t = pairs_ + i;
    const double right = tangential_alone(i, slip_free[i] + motion_[t], slip_velocity[i], last.force[t]);
    largest = std::max(largest, std::abs(x[t] - right));
  }
  const double scale = x.head(pairs_).maxCoeff();
  return scale > 0.0 ? largest / scale : largest > 0.0 ? 1.0 : 0.0;
}

void RootProblem::finish() {
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    if (!state.closed) solution_.force[i] = 0.0;  // the forces may be those of states before
    if (!state.closed && friction_) solution_.force[pairs_ + i] = 0.0;
    if (!state.closed && cone_) solution_.force[2 * pairs_ + i] = 0.0;
    const bool stick = state.tangent == Tangent::stick || (friction_of(i) > 0.0 && held(i));
    solution_.states[static_cast<std::size_t>(i)] = !state.closed ? ContactState::open
                                                    : stick       ? ContactState::stick
                                                                  : ContactState::slip;
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
