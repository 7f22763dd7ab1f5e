#include "implicit_solver/contact/root_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ricochet::implicit_solver {

using solver::State;

namespace {
constexpr int max_state_iterations = 30;
constexpr int max_sweeps = 5000;
constexpr double round_off = 1e-12;
}  // namespace

RootProblem::RootProblem(const scene::Contact& law, Eigen::MatrixXd compliance, std::vector<double> area_m2, double dt)
    : law_(law),
      friction_(law.friction_coefficient > 0.0),
      regularised_(law.friction_law == scene::FrictionLaw::regularised),
      pairs_(static_cast<int>(area_m2.size())),
      dt_(dt),
      compliance_(std::move(compliance)),
      matrix_(compliance_.rows(), compliance_.cols()),
      area_m2_(std::move(area_m2)),
      states_(static_cast<std::size_t>(pairs_)),
      rhs_(compliance_.rows()),
      motion_(compliance_.rows()),
      solution_(open()) {}

RootProblem::Solution RootProblem::open() const {
  return {Eigen::VectorXd::Zero(compliance_.rows()), std::vector<State>(static_cast<std::size_t>(pairs_), State::open), 0};
}

double RootProblem::slack(int pair) const {
  if (law_.enforcement != scene::Enforcement::penalty) return 0.0;
  return 1.0 / (law_.penalty_pa_m * area_m2_[static_cast<std::size_t>(pair)]);
}

void RootProblem::start_from(const Solution& last) {
  for (int i = 0; i < pairs_; ++i) {
    auto& state = states_[static_cast<std::size_t>(i)];
    const State before = last.states[static_cast<std::size_t>(i)];
    state.closed = before != State::open;
    state.tangent = Tangent::none;
    if (!state.closed || held(i)) continue;
    const bool plus = last.force[pairs_ + i] > 0.0;
    state.tangent = regularised_ ? Tangent::regularised
                    : before == State::stick ? Tangent::stick
                    : plus ? Tangent::slip_plus : Tangent::slip_minus;
  }
}

bool RootProblem::held(int pair) const { return !friction_ || compliance_(pairs_ + pair, pairs_ + pair) <= 0.0; }

/// Rows of the present states; open pairs keep an identity row.
void RootProblem::assemble() {
  const double mu = law_.friction_coefficient;
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    if (state.closed) {
      matrix_.row(i) = compliance_.row(i);
      matrix_(i, i) += slack(i);
    } else {
      matrix_.row(i).setZero();
      matrix_(i, i) = 1.0;
    }
    if (!friction_) continue;
    const int t = pairs_ + i;
    matrix_.row(t).setZero();
    matrix_(t, t) = 1.0;
    switch (state.tangent) {
      case Tangent::none: break;
      case Tangent::stick:
        matrix_.row(t) = compliance_.row(t);
        matrix_(t, t) += slack(i);
        break;
      case Tangent::slip_plus: matrix_(t, i) = -mu; break;
      case Tangent::slip_minus: matrix_(t, i) = mu; break;
      case Tangent::regularised: break;  // nonlinear: filled at each Newton iteration
    }
  }
}

void RootProblem::solve_linear(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                               const Eigen::VectorXd& slip_velocity, const Solution& last) {
  const bool nonlinear = friction_ && regularised_;
  const bool refactor = nonlinear || factored_states_ != states_;
  if (refactor) assemble();
  rhs_.setZero();
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    if (!state.closed) continue;
    rhs_[i] = -gap_free[i];
    if (!friction_) continue;
    const int t = pairs_ + i;
    if (state.tangent == Tangent::stick) rhs_[t] = -slip_free[i] + slack(i) * last.force[t];
    if (state.tangent != Tangent::regularised) continue;
    // tau + mu lambda tanh(xi v(x)) = 0, linearised about v0: v of the present x; or 0, where tanh is steepest and Newton's method
    // cannot overshoot, if the present tau turns the slip around. dv/dslip = 2/dt
    const double xi = law_.friction_regularisation_s_m, mu = law_.friction_coefficient;
    const double moved = compliance_.row(t).dot(solution_.force);
    const double velocity = 2.0 * (slip_free[i] + moved) / dt_ - slip_velocity[i];
    const double without = velocity - 2.0 / dt_ * compliance_(t, t) * solution_.force[t];
    const double about = velocity * without < 0.0 ? 0.0 : velocity;
    const double tanh = std::tanh(xi * about);
    const double slope = mu * std::max(0.0, solution_.force[i]) * xi * (1.0 - tanh * tanh) * 2.0 / dt_;
    matrix_.row(t) = slope * compliance_.row(t);
    matrix_(t, t) += 1.0;
    matrix_(t, i) += mu * tanh;
    rhs_[t] = slope * (moved - 0.5 * dt_ * (velocity - about));
  }
  if (refactor) {
    factor_.compute(matrix_);
    factored_states_ = states_;
  }
  solution_.force = factor_.solve(rhs_);
}

bool RootProblem::update_states(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free) {
  const double mu = law_.friction_coefficient;
  motion_.noalias() = compliance_ * solution_.force;
  const double force_scale = round_off * solution_.force.head(pairs_).cwiseAbs().maxCoeff();
  const double gap_scale = round_off * gap_free.cwiseAbs().maxCoeff();
  bool changed = false;
  for (int i = 0; i < pairs_; ++i) {
    auto& state = states_[static_cast<std::size_t>(i)];
    const PairState before = state;
    const double normal = solution_.force[i];
    if (state.closed && normal < -force_scale) {
      state = {};
    } else if (!state.closed && gap_free[i] + motion_[i] < -gap_scale) {
      state.closed = true;
      if (!held(i)) state.tangent = regularised_ ? Tangent::regularised : Tangent::stick;
    } else if (state.closed && !held(i) && !regularised_) {
      const double tangential = solution_.force[pairs_ + i];
      const double slip = slip_free[i] + motion_[pairs_ + i];
      if (state.tangent == Tangent::stick && std::abs(tangential) > mu * normal + force_scale) {
        state.tangent = tangential > 0.0 ? Tangent::slip_plus : Tangent::slip_minus;
      } else if ((state.tangent == Tangent::slip_plus && slip > 0.0) || (state.tangent == Tangent::slip_minus && slip < 0.0)) {
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
  for (solution_.iterations = 1; solution_.iterations <= max_state_iterations; ++solution_.iterations) {
    before_ = solution_.force;
    const bool any = std::any_of(states_.begin(), states_.end(), [](const PairState& s) { return s.closed; });
    if (any) {
      solve_linear(gap_free, slip_free, slip_velocity, last);
    } else {
      solution_.force.setZero();
    }
    const bool changed = update_states(gap_free, slip_free);
    const double step = (solution_.force - before_).cwiseAbs().maxCoeff();
    const bool converged = !(friction_ && regularised_) || step <= 1e-11 * solution_.force.cwiseAbs().maxCoeff();
    if (!changed && converged) {
      finish();
      return solution_;
    }
  }
  if (!(friction_ && regularised_)) projected_gauss_seidel(gap_free, slip_free, last);
  finish();
  return solution_;
}

void RootProblem::stick_all() {
  for (int i = 0; i < pairs_; ++i) {
    states_[static_cast<std::size_t>(i)] = {.closed = true, .tangent = held(i) ? Tangent::none : Tangent::stick};
  }
}

const RootProblem::Solution& RootProblem::hold(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free) {
  stick_all();
  if (factored_states_ != states_) {
    assemble();
    factor_.compute(matrix_);
    factored_states_ = states_;
  }
  rhs_.setZero();
  for (int i = 0; i < pairs_; ++i) {
    rhs_[i] = -gap_free[i];
    if (!held(i)) rhs_[pairs_ + i] = -slip_free[i];
  }
  solution_.force = factor_.solve(rhs_);
  finish();
  return solution_;
}

const RootProblem::Solution& RootProblem::spring(const Eigen::VectorXd& gap, const Eigen::VectorXd& slip) {
  stick_all();
  solution_.force.setZero();
  for (int i = 0; i < pairs_ && law_.enforcement == scene::Enforcement::penalty; ++i) {
    solution_.force[i] = -gap[i] / slack(i);
    if (!held(i)) solution_.force[pairs_ + i] = -slip[i] / slack(i);
  }
  finish();
  return solution_;
}

/// Gauss-Seidel on the complementarity conditions; slow but it cannot cycle without friction.
void RootProblem::projected_gauss_seidel(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                         const Solution& last) {
  auto& x = solution_.force;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    double largest_change = 0.0;
    for (int i = 0; i < pairs_; ++i) {
      const double normal_before = x[i];
      const double gap = gap_free[i] + compliance_.row(i).dot(x) + slack(i) * x[i];
      x[i] = std::max(0.0, x[i] - gap / (compliance_(i, i) + slack(i)));
      largest_change = std::max(largest_change, std::abs(x[i] - normal_before));
      if (held(i)) continue;
      const int t = pairs_ + i;
      const double before = x[t], limit = law_.friction_coefficient * x[i];
      const double slip = slip_free[i] + compliance_.row(t).dot(x) + slack(i) * (x[t] - last.force[t]);
      x[t] = std::clamp(x[t] - slip / (compliance_(t, t) + slack(i)), -limit, limit);
      largest_change = std::max(largest_change, std::abs(x[t] - before));
    }
    if (largest_change <= 1e-13 * x.cwiseAbs().maxCoeff()) break;
  }
  for (int i = 0; i < pairs_; ++i) {
    auto& state = states_[static_cast<std::size_t>(i)];
    state = {.closed = x[i] > 0.0, .tangent = Tangent::none};
    if (!state.closed || held(i)) continue;
    const double tangential = x[pairs_ + i];
    state.tangent = std::abs(tangential) < law_.friction_coefficient * x[i] ? Tangent::stick
                    : tangential > 0.0 ? Tangent::slip_plus : Tangent::slip_minus;
  }
}

void RootProblem::finish() {
  for (int i = 0; i < pairs_; ++i) {
    const auto& state = states_[static_cast<std::size_t>(i)];
    if (!state.closed) solution_.force[i] = 0.0;  // what the dense solve leaves of its identity row is round-off
    if (!state.closed && friction_) solution_.force[pairs_ + i] = 0.0;
    const bool stick = state.tangent == Tangent::stick || (friction_ && held(i));
    solution_.states[static_cast<std::size_t>(i)] = !state.closed ? State::open : stick ? State::stick : State::slip;
  }
}

}  // namespace ricochet::implicit_solver
