#include "explicit_solver/explicit_contact.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/solver/friction.hpp"

namespace ricochet::explicit_solver {

using solver::BodyState;
using solver::ContactState;
using solver::Pair;

namespace {

auto acceleration_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].a; };
}
auto before_of(const std::vector<const Eigen::VectorXd*>& u_before) {
  return [&u_before](int part) -> const Eigen::VectorXd& { return *u_before[static_cast<std::size_t>(part)]; };
}

}  // namespace

ExplicitContact::ExplicitContact(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts,
                                 double dt)
    : law_(&*problem.scene.contact),
      dt_(dt),
      surface_(problem, parts),
      forces_(surface_.pairs.size()),
      mean_forces_(surface_.pairs.size()) {}

double ExplicitContact::inverse_mass(const Pair& pair, const std::vector<BodyState>& states,
                                     const Eigen::Vector2d& direction) const {
  double sum = 0.0;
  for (const auto& side : {pair.a, pair.b}) {
    if (side.part < 0) continue;
    const auto& inverse = states[static_cast<std::size_t>(side.part)].inverse_mass;
    for (int c = 0; c < surface_.components; ++c)
      sum += direction[c] * direction[c] * inverse[side.node * surface_.components + c];
  }
  return sum;
}

void ExplicitContact::move_masses(std::vector<BodyState>& states) {
  if (law_->multiplier_update != scene::MultiplierUpdate::massless) return;
  massless_.emplace(surface_, states);
  made_j_.assign(surface_.pairs.size(), 0.0);
}

void ExplicitContact::settle(const std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& external,
                             const std::vector<Eigen::VectorXd*>& u) {
  if (massless_) static_normal_n_ = massless_->settle(states, external, u);
}

double ExplicitContact::normal_force(std::size_t i, const std::vector<BodyState>& states, double rate_n,
                                     double acting_time) const {
  if (massless_) return static_normal_n_[static_cast<Eigen::Index>(i)];
  const auto& pair = surface_.pairs[i];
  const double gap_now = surface_.gap(pair, states);
  if (law_->enforcement == scene::Enforcement::penalty)
    return law_->penalty_pa_m * pair.area_m2 * std::max(0.0, -gap_now);
  const double inverse = inverse_mass(pair, states, surface_.normal);
  return inverse > 0.0 ? std::max(0.0, -(gap_now + dt_ * rate_n)) / (dt_ * acting_time * inverse) : 0.0;
}

ExplicitContact::Force ExplicitContact::find_force(std::size_t i, const std::vector<BodyState>& states, double rate_n,
                                                   double rate_t, double acting_time) const {
  const auto& pair = surface_.pairs[i];
  if (frozen_ == participant::FrozenContact::open) return {};
  if (frozen_) return holding_force(pair, states, rate_n, rate_t, acting_time);
  Force force;
  force.normal = normal_force(i, states, rate_n, acting_time);
  if (force.normal == 0.0) return force;
  force.state = ContactState::slip;
  if (law_->friction_coefficient == 0.0) return force;
  const double inverse = inverse_mass(pair, states, surface_.tangent);
  const double holding = inverse > 0.0 ? -rate_t / (acting_time * inverse) : 0.0;
  force.tangential = solver::friction_of_pair(*law_, law_->friction_coefficient * force.normal, rate_t, holding);
  if (force.tangential == holding) force.state = ContactState::stick;
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
          .state = ContactState::stick};
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

void ExplicitContact::account(std::size_t i, std::vector<BodyState>& states,
                              const std::vector<const Eigen::VectorXd*>& u_before) {
  const auto& pair = surface_.pairs[i];
  const Force& mean = mean_forces_[i];
  const auto moved = [&](const Eigen::Vector2d& direction) {
    return relative(pair, direction, surface_.components, displacement_of(states)) -
           relative(pair, direction, surface_.components, before_of(u_before));
  };
  const double made = mean.normal * moved(surface_.normal);
  if (massless_) made_j_[i] = made;
  work_normal_j_ += made;
  dissipated_friction_j_ -= mean.tangential * moved(surface_.tangent);
  book_impulse(pair, dt_ * mean.normal, dt_ * mean.tangential, states);
}

/// Forces between two bodies change no total momentum; those of a plane do.
void ExplicitContact::book_impulse(const Pair& pair, double normal_n_s, double tangential_n_s,
                                   std::vector<BodyState>& states) {
  impulse_normal_n_s_ += normal_n_s;
  impulse_tangential_n_s_ += tangential_n_s;
  if (pair.b.part >= 0) return;
  auto& totals = states[static_cast<std::size_t>(pair.a.part)].totals;
  totals.impulse_n_kg_m_s -= normal_n_s;
  totals.impulse_t_kg_m_s -= tangential_n_s;
  states[static_cast<std::size_t>(pair.a.part)].add_angular_impulse(
      pair.a.node, -(normal_n_s * surface_.normal + tangential_n_s * surface_.tangent));
}

/// After the normal impulse of the window has changed: the friction impulse stays within its cone and, of a slipping
/// pair that this does not turn around, on it.
void ExplicitContact::clip_friction(std::size_t i, std::vector<BodyState>& states) {
  const auto& pair = surface_.pairs[i];
  double& mean = mean_forces_[i].tangential;
  const double limit = law_->friction_coefficient * mean_forces_[i].normal,
               inverse = inverse_mass(pair, states, surface_.tangent);
  const double target = mean_forces_[i].state == ContactState::slip && mean != 0.0 ? std::copysign(limit, mean)
                                                                                   : std::clamp(mean, -limit, limit);
  if (target == mean || inverse == 0.0) return;
  const double rate = relative(pair, surface_.tangent, surface_.components, velocity_of(states));
  double impulse = dt_ * (target - mean);
  if (std::abs(target) > std::abs(mean) && (rate + inverse * impulse) * rate < 0.0) impulse = -rate / inverse;
  for (const auto& [side, sign] : {std::pair{pair.b, 1.0}, std::pair{pair.a, -1.0}}) {
    if (side.part < 0) continue;
    auto& state = states[static_cast<std::size_t>(side.part)];
    for (int c = 0; c < surface_.components; ++c) {
      const int dof = side.node * surface_.components + c;
      state.v[dof] += sign * impulse * surface_.tangent[c] * state.inverse_mass[dof];
    }
  }
  dissipated_friction_j_ -= impulse * (rate + 0.5 * impulse * inverse);
  book_impulse(pair, 0.0, impulse, states);
  mean += impulse / dt_;
}

void ExplicitContact::finish(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  if (!massless_) return;
  massless_->for_each_dof(
      [&](std::size_t part, int dof) { states[part].v[dof] = (states[part].u[dof] - (*u_before[part])[dof]) / dt_; });
  velocity_of_part_.clear();
  for (auto& state : states) velocity_of_part_.push_back(state.v.data());
  massless_->begin_trial();
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const double impulse = massless_->give_back(i, made_j_[i], dt_ * mean_forces_[i].normal, states, velocity_of_part_);
    mean_forces_[i].normal += impulse / dt_;
    book_impulse(surface_.pairs[i], impulse, 0.0, states);
    clip_friction(i, states);
  }
  work_normal_j_ += massless_->trial_work_j();
  massless_->accept();
}

/// dt^2/8 a^T M a of a pair's nodes: what the staggered metric takes off 1/2 v^T M v. A contact force at n = 0 changes
/// it at once; that change is the energy an impact at the start costs.
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
    forces_[i] = find_force(i, states, rate(surface_.normal), rate(surface_.tangent), 0.5 * dt_);
    const double before = staggered_correction(surface_.pairs[i], states);
    push(surface_.pairs[i], forces_[i], states);
    work_normal_j_ -= staggered_correction(surface_.pairs[i], states) - before;
  }
}

void ExplicitContact::apply(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto rate = [&](const Eigen::Vector2d& direction) {
      const double half_velocity =
          (relative(surface_.pairs[i], direction, surface_.components, displacement_of(states)) -
           relative(surface_.pairs[i], direction, surface_.components, before_of(u_before))) /
          dt_;
      return half_velocity + dt_ * relative(surface_.pairs[i], direction, surface_.components, acceleration_of(states));
    };
    const Force old = forces_[i];
    forces_[i] = find_force(i, states, rate(surface_.normal), rate(surface_.tangent), dt_);
    push(surface_.pairs[i], forces_[i], states);
    mean_forces_[i] = {.normal = 0.5 * (old.normal + forces_[i].normal),
                       .tangential = 0.5 * (old.tangential + forces_[i].tangential),
                       .state = forces_[i].state};
    account(i, states, u_before);
  }
}

int ExplicitContact::pairs_closed() const {
  return static_cast<int>(
      std::count_if(forces_.begin(), forces_.end(), [](const Force& f) { return f.state != ContactState::open; }));
}

solver::ContactRecord ExplicitContact::report(const std::vector<BodyState>& states) const {
  solver::ContactRecord report = surface_.report(states, mean_forces_);
  report.contact_impulse_n_s = impulse_normal_n_s_;
  report.friction_impulse_n_s = impulse_tangential_n_s_;
  report.energy_contact_j = work_normal_j_;
  report.energy_friction_j = dissipated_friction_j_;
  return report;
}

}  // namespace ricochet::explicit_solver
