#include "explicit_solver/explicit_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ricochet::explicit_solver {

using solver::BodyState;
using solver::Pair;
using solver::State;

namespace {

auto displacement_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].u; };
}
auto velocity_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].v; };
}
auto acceleration_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].a; };
}
auto before_of(const std::vector<const Eigen::VectorXd*>& u_before) {
  return [&u_before](int part) -> const Eigen::VectorXd& { return *u_before[static_cast<std::size_t>(part)]; };
}

}  // namespace

ExplicitContact::ExplicitContact(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts, double dt)
    : law_(&*problem.scene.contact),
      normal_(problem.contact.normal),
      tangent_(-problem.contact.normal[1], problem.contact.normal[0]),
      components_(problem.scene.components()),
      dt_(dt),
      pairs_(solver::local_pairs(problem, parts)),
      forces_(pairs_.size()),
      stress_(problem, parts) {}

double ExplicitContact::gap(const Pair& pair, const std::vector<BodyState>& states) const {
  return pair.gap0_m + relative(pair, normal_, components_, displacement_of(states));
}

double ExplicitContact::inverse_mass(const Pair& pair, const std::vector<BodyState>& states,
                                     const Eigen::Vector2d& direction) const {
  double sum = 0.0;
  for (const auto& side : {pair.a, pair.b}) {
    if (side.part < 0) continue;
    const auto& inverse = states[static_cast<std::size_t>(side.part)].inverse_mass;
    for (int c = 0; c < components_; ++c) sum += direction[c] * direction[c] * inverse[side.node * components_ + c];
  }
  return sum;
}

double ExplicitContact::friction_force(double normal, double slip_rate, double holding) const {
  const double limit = law_->friction_coefficient * normal;
  if (law_->friction_law == scene::FrictionLaw::regularised) {
    return -limit * std::tanh(law_->friction_regularisation_s_m * slip_rate);  // Eq. 14, 15
  }
  return std::clamp(holding, -limit, limit);
}

ExplicitContact::Force ExplicitContact::find_force(const Pair& pair, const std::vector<BodyState>& states, double rate_n,
                                                   double rate_t, double acting_time) const {
  Force force;
  const double gap_now = gap(pair, states);
  if (law_->enforcement == scene::Enforcement::penalty) {
    force.normal = law_->penalty_pa_m * pair.area_m2 * std::max(0.0, -gap_now);
  } else {
    const double inverse = inverse_mass(pair, states, normal_);
    const double gap_free = gap_now + dt_ * rate_n;
    if (inverse > 0.0) force.normal = std::max(0.0, -gap_free) / (dt_ * acting_time * inverse);
  }
  if (force.normal == 0.0) return force;
  force.state = State::slip;
  if (law_->friction_coefficient == 0.0) return force;
  const double inverse = inverse_mass(pair, states, tangent_);
  const double holding = inverse > 0.0 ? -rate_t / (acting_time * inverse) : 0.0;
  force.tangential = friction_force(force.normal, rate_t, holding);
  if (force.tangential == holding) force.state = State::stick;
  return force;
}

void ExplicitContact::push(const Pair& pair, const Force& force, std::vector<BodyState>& states) const {
  const Eigen::Vector2d on_b = force.normal * normal_ + force.tangential * tangent_;
  for (const auto& [side, sign] : {std::pair{pair.b, 1.0}, std::pair{pair.a, -1.0}}) {
    if (side.part < 0) continue;
    auto& state = states[static_cast<std::size_t>(side.part)];
    for (int c = 0; c < components_; ++c) {
      const int dof = side.node * components_ + c;
      state.a[dof] += sign * on_b[c] * state.inverse_mass[dof];
    }
  }
}

void ExplicitContact::account(const Pair& pair, const Force& old, const Force& now, std::vector<BodyState>& states,
                              const std::vector<const Eigen::VectorXd*>& u_before) {
  const auto moved = [&](const Eigen::Vector2d& direction) {
    return relative(pair, direction, components_, displacement_of(states)) -
           relative(pair, direction, components_, before_of(u_before));
  };
  work_normal_j_ += 0.5 * (old.normal + now.normal) * moved(normal_);
  dissipated_friction_j_ -= 0.5 * (old.tangential + now.tangential) * moved(tangent_);
  if (pair.b.part >= 0) return;  // forces between two bodies change no total momentum
  auto& totals = states[static_cast<std::size_t>(pair.a.part)].totals;
  totals.impulse_n_kg_m_s -= 0.5 * dt_ * (old.normal + now.normal);
  totals.impulse_t_kg_m_s -= 0.5 * dt_ * (old.tangential + now.tangential);
}

/// dt^2/8 a^T M a of a pair's nodes: what the staggered metric takes off 1/2 v^T M v. A contact force at n = 0 changes it at
/// once; that change is the energy an impact at the start costs.
double ExplicitContact::staggered_correction(const Pair& pair, const std::vector<BodyState>& states) const {
  double sum = 0.0;
  for (const auto& side : {pair.a, pair.b}) {
    if (side.part < 0) continue;
    const auto& state = states[static_cast<std::size_t>(side.part)];
    for (int c = 0; c < components_; ++c) {
      const int dof = side.node * components_ + c;
      sum += 0.125 * dt_ * dt_ * state.mass[dof] * state.a[dof] * state.a[dof];
    }
  }
  return sum;
}

void ExplicitContact::start(std::vector<BodyState>& states) {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto rate = [&](const Eigen::Vector2d& direction) {
      return relative(pairs_[i], direction, components_, velocity_of(states)) +
             0.5 * dt_ * relative(pairs_[i], direction, components_, acceleration_of(states));
    };
    forces_[i] = find_force(pairs_[i], states, rate(normal_), rate(tangent_), 0.5 * dt_);
    const double before = staggered_correction(pairs_[i], states);
    push(pairs_[i], forces_[i], states);
    work_normal_j_ -= staggered_correction(pairs_[i], states) - before;
  }
}

void ExplicitContact::apply(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto rate = [&](const Eigen::Vector2d& direction) {
      const double half_velocity = (relative(pairs_[i], direction, components_, displacement_of(states)) -
                                    relative(pairs_[i], direction, components_, before_of(u_before))) / dt_;
      return half_velocity + dt_ * relative(pairs_[i], direction, components_, acceleration_of(states));
    };
    const Force old = forces_[i];
    forces_[i] = find_force(pairs_[i], states, rate(normal_), rate(tangent_), dt_);
    push(pairs_[i], forces_[i], states);
    account(pairs_[i], old, forces_[i], states, u_before);
  }
}

int ExplicitContact::pairs_closed() const {
  return static_cast<int>(std::count_if(forces_.begin(), forces_.end(), [](const Force& f) { return f.state != State::open; }));
}

double ExplicitContact::gap_min(const std::vector<BodyState>& states) const {
  double smallest = std::numeric_limits<double>::max();
  for (const auto& pair : pairs_) smallest = std::min(smallest, gap(pair, states));
  return smallest;
}

double ExplicitContact::gap_rate_min(const std::vector<BodyState>& states) const {
  double smallest = std::numeric_limits<double>::max();
  for (const auto& pair : pairs_) smallest = std::min(smallest, relative(pair, normal_, components_, velocity_of(states)));
  return smallest;
}

solver::Report ExplicitContact::report(const std::vector<BodyState>& states) const {
  solver::Report report;
  double area = 0.0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    report.contact_force_n += forces_[i].normal;
    report.friction_force_n += forces_[i].tangential;
    report.pairs_open += forces_[i].state == State::open;
    report.pairs_stick += forces_[i].state == State::stick;
    report.pairs_slip += forces_[i].state == State::slip;
    area += pairs_[i].area_m2;
  }
  report.gap_min_m = gap_min(states);
  report.contact_pressure_mean_pa = report.contact_force_n / area;
  report.principal_stress_mean_pa = stress_.mean(displacement_of(states));
  report.energy_contact_j = work_normal_j_;
  report.energy_friction_j = dissipated_friction_j_;
  return report;
}

}  // namespace ricochet::explicit_solver
