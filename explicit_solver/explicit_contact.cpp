#include "explicit_solver/explicit_contact.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ricochet::explicit_solver {

using solver::BodyState;
using solver::Pair;
using solver::State;

namespace {

auto acceleration_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].a; };
}
auto before_of(const std::vector<const Eigen::VectorXd*>& u_before) {
  return [&u_before](int part) -> const Eigen::VectorXd& { return *u_before[static_cast<std::size_t>(part)]; };
}

}  // namespace

ExplicitContact::ExplicitContact(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts, double dt)
    : law_(&*problem.scene.contact),
      dt_(dt),
      surface_(problem, parts),
      forces_(surface_.pairs.size()) {}

double ExplicitContact::inverse_mass(const Pair& pair, const std::vector<BodyState>& states,
                                     const Eigen::Vector2d& direction) const {
  double sum = 0.0;
  for (const auto& side : {pair.a, pair.b}) {
    if (side.part < 0) continue;
    const auto& inverse = states[static_cast<std::size_t>(side.part)].inverse_mass;
    for (int c = 0; c < surface_.components; ++c) sum += direction[c] * direction[c] * inverse[side.node * surface_.components + c];
  }
  return sum;
}

/// `slip_rate`: relative tangential velocity at n + 1/2 without friction; `holding`: the force that would make it zero.
double ExplicitContact::friction_force(double normal, double slip_rate, double holding) const {
  const double limit = law_->friction_coefficient * normal;
  if (law_->friction_law == scene::FrictionLaw::return_mapping) return std::clamp(holding, -limit, limit);
  if (slip_rate == 0.0 || holding == 0.0) return 0.0;
  // Eq. 14, 15 at the velocity that friction leaves, v + d tanh(xi v) = slip_rate: taken at slip_rate itself, it would count
  // what one window of it stops. Newton's method from rest stays on one side, where the law is steepest first.
  const double xi = law_->friction_regularisation_s_m, stops = limit * std::abs(slip_rate / holding);
  double v = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double tanh = std::tanh(xi * v);
    const double change = (slip_rate - v - stops * tanh) / (1.0 + stops * xi * (1.0 - tanh * tanh));
    v += change;
    if (std::abs(change) <= 1e-14 * std::abs(slip_rate)) break;
  }
  return -limit * std::tanh(xi * v);
}

ExplicitContact::Force ExplicitContact::find_force(const Pair& pair, const std::vector<BodyState>& states, double rate_n,
                                                   double rate_t, double acting_time) const {
  if (frozen_ == participant::FrozenContact::open) return {};
  if (frozen_) return holding_force(pair, states, rate_n, rate_t, acting_time);
  Force force;
  const double gap_now = surface_.gap(pair, states);
  if (law_->enforcement == scene::Enforcement::penalty) {
    force.normal = law_->penalty_pa_m * pair.area_m2 * std::max(0.0, -gap_now);
  } else {
    const double inverse = inverse_mass(pair, states, surface_.normal);
    const double gap_free = gap_now + dt_ * rate_n;
    if (inverse > 0.0) force.normal = std::max(0.0, -gap_free) / (dt_ * acting_time * inverse);
  }
  if (force.normal == 0.0) return force;
  force.state = State::slip;
  if (law_->friction_coefficient == 0.0) return force;
  const double inverse = inverse_mass(pair, states, surface_.tangent);
  const double holding = inverse > 0.0 ? -rate_t / (acting_time * inverse) : 0.0;
  force.tangential = friction_force(force.normal, rate_t, holding);
  if (force.tangential == holding) force.state = State::stick;
  return force;
}

/// Frozen sticking: the linear part of `find_force`, normally and (with friction) tangentially.
ExplicitContact::Force ExplicitContact::holding_force(const Pair& pair, const std::vector<BodyState>& states,
                                                      double rate_n, double rate_t, double acting_time) const {
  const auto hold = [&](const Eigen::Vector2d& direction, double rate) {
    const double inverse = inverse_mass(pair, states, direction);
    const double moved = surface_.moved(pair, direction, states) + dt_ * rate;
    return inverse > 0.0 ? -moved / (dt_ * acting_time * inverse) : 0.0;
  };
  const bool penalty = law_->enforcement == scene::Enforcement::penalty;
  const bool friction = law_->friction_coefficient > 0.0;
  const double spring = -law_->penalty_pa_m * pair.area_m2 * surface_.moved(pair, surface_.normal, states);
  return {.normal = penalty ? spring : hold(surface_.normal, rate_n),
          .tangential = friction ? hold(surface_.tangent, rate_t) : 0.0,
          .state = State::stick};
}

void ExplicitContact::push(const Pair& pair, const Force& force, std::vector<BodyState>& states) const {
  const Eigen::Vector2d on_b = force.normal * surface_.normal + force.tangential * surface_.tangent;
  for (const auto& [side, sign] : {std::pair{pair.b, 1.0}, std::pair{pair.a, -1.0}}) {
    if (side.part < 0) continue;
    auto& state = states[static_cast<std::size_t>(side.part)];
    for (int c = 0; c < surface_.components; ++c) {
      const int dof = side.node * surface_.components + c;
      state.a[dof] += sign * on_b[c] * state.inverse_mass[dof];
    }
  }
}

void ExplicitContact::account(const Pair& pair, const Force& old, const Force& now, std::vector<BodyState>& states,
                              const std::vector<const Eigen::VectorXd*>& u_before) {
  const auto moved = [&](const Eigen::Vector2d& direction) {
    return relative(pair, direction, surface_.components, displacement_of(states)) -
           relative(pair, direction, surface_.components, before_of(u_before));
  };
  work_normal_j_ += 0.5 * (old.normal + now.normal) * moved(surface_.normal);
  dissipated_friction_j_ -= 0.5 * (old.tangential + now.tangential) * moved(surface_.tangent);
  if (pair.b.part >= 0) return;  // forces between two bodies change no total momentum
  auto& totals = states[static_cast<std::size_t>(pair.a.part)].totals;
  totals.impulse_n_kg_m_s -= 0.5 * dt_ * (old.normal + now.normal);
  totals.impulse_t_kg_m_s -= 0.5 * dt_ * (old.tangential + now.tangential);
  const Eigen::Vector2d sum = (old.normal + now.normal) * surface_.normal + (old.tangential + now.tangential) * surface_.tangent;
  states[static_cast<std::size_t>(pair.a.part)].add_angular_impulse(pair.a.node, -0.5 * dt_ * sum);
}

/// dt^2/8 a^T M a of a pair's nodes: what the staggered metric takes off 1/2 v^T M v. A contact force at n = 0 changes it at
/// once; that change is the energy an impact at the start costs.
double ExplicitContact::staggered_correction(const Pair& pair, const std::vector<BodyState>& states) const {
  double sum = 0.0;
  for (const auto& side : {pair.a, pair.b}) {
    if (side.part < 0) continue;
    const auto& state = states[static_cast<std::size_t>(side.part)];
    for (int c = 0; c < surface_.components; ++c) {
      const int dof = side.node * surface_.components + c;
      sum += 0.125 * dt_ * dt_ * state.mass[dof] * state.a[dof] * state.a[dof];
    }
  }
  return sum;
}

void ExplicitContact::start(std::vector<BodyState>& states) {
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto rate = [&](const Eigen::Vector2d& direction) {
      return relative(surface_.pairs[i], direction, surface_.components, velocity_of(states)) +
             0.5 * dt_ * relative(surface_.pairs[i], direction, surface_.components, acceleration_of(states));
    };
    forces_[i] = find_force(surface_.pairs[i], states, rate(surface_.normal), rate(surface_.tangent), 0.5 * dt_);
    const double before = staggered_correction(surface_.pairs[i], states);
    push(surface_.pairs[i], forces_[i], states);
    work_normal_j_ -= staggered_correction(surface_.pairs[i], states) - before;
  }
}

void ExplicitContact::apply(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto rate = [&](const Eigen::Vector2d& direction) {
      const double half_velocity = (relative(surface_.pairs[i], direction, surface_.components, displacement_of(states)) -
                                    relative(surface_.pairs[i], direction, surface_.components, before_of(u_before))) / dt_;
      return half_velocity + dt_ * relative(surface_.pairs[i], direction, surface_.components, acceleration_of(states));
    };
    const Force old = forces_[i];
    forces_[i] = find_force(surface_.pairs[i], states, rate(surface_.normal), rate(surface_.tangent), dt_);
    push(surface_.pairs[i], forces_[i], states);
    account(surface_.pairs[i], old, forces_[i], states, u_before);
  }
}

int ExplicitContact::pairs_closed() const {
  return static_cast<int>(std::count_if(forces_.begin(), forces_.end(), [](const Force& f) { return f.state != State::open; }));
}

solver::Report ExplicitContact::report(const std::vector<BodyState>& states) const {
  solver::Report report = surface_.report(states, forces_);
  report.energy_contact_j = work_normal_j_;
  report.energy_friction_j = dissipated_friction_j_;
  return report;
}

}  // namespace ricochet::explicit_solver
