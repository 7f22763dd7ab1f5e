#include "explicit_solver/explicit_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "common/solver/friction.hpp"

namespace ricochet::explicit_solver {

using solver::BodyState;
using solver::ContactRow;
using solver::ContactState;
using solver::Pair;

namespace {

auto acceleration_of(const std::vector<BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].a; };
}
auto push_accelerations(std::vector<BodyState>& states) {
  return [&states](int part) -> Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].a; };
}
auto push_velocities(std::vector<BodyState>& states) {
  return [&states](int part) -> Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].v; };
}
auto before_of(const std::vector<const Eigen::VectorXd*>& u_before) {
  return [&u_before](int part) -> const Eigen::VectorXd& { return *u_before[static_cast<std::size_t>(part)]; };
}

}  // namespace

ExplicitContact::ExplicitContact(const scene::Contact& law, solver::ContactSurface surface, double dt,
                                 std::optional<solver::SlidingRows> sliding)
    : law_(&law),
      dt_(dt),
      surface_(std::move(surface)),
      shared_(surface_.askew || solver::share_nodes(surface_.pairs)),
      sliding_(std::move(sliding)) {
  if (sliding_ && !sliding_->any()) sliding_.reset();
  state_.forces.resize(surface_.pairs.size());
  state_.mean_forces.resize(surface_.pairs.size());
  state_.impulses = surface_.no_impulses();
  report_ = surface_.empty_record();
}

void ExplicitContact::move_masses(std::vector<BodyState>& states) {
  if (law_->multiplier_update != scene::MultiplierUpdate::massless) return;
  massless_.emplace(surface_, states);
  made_j_.assign(surface_.pairs.size(), 0.0);
}

void ExplicitContact::settle(const std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& external,
                             const std::vector<Eigen::VectorXd*>& u) {
  if (massless_) state_.static_normal_n = massless_->settle(states, external, u);
}

/// The rows of a pair, along normal, tangent and binormal.
std::array<const ContactRow*, 3> rows_of(const Pair& pair) { return {&pair.normal, &pair.tangent, &pair.binormal}; }

Eigen::Vector3d vector_of(const ExplicitContact::Force& force) {
  return {force.normal, force.tangential[0], force.tangential[1]};
}

/// Pairs that share nodes, and by how much the forces of one accelerate the rows of the other: the blocks of N M^-1
/// N^T.
void ExplicitContact::couple_pairs(const std::vector<BodyState>& states) {
  struct Use {
    int part, dof;
    std::size_t pair;
    int direction;
    double coefficient;
  };
  std::vector<Use> uses;
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto rows = rows_of(surface_.pairs[i]);
    for (int k = 0; k < 3; ++k)
      for (const auto& e : rows[static_cast<std::size_t>(k)]->entries)
        uses.push_back({e.part, e.dof, i, k, e.coefficient});
  }
  const auto by_dof = [](const Use& x, const Use& y) { return std::tie(x.part, x.dof) < std::tie(y.part, y.dof); };
  std::stable_sort(uses.begin(), uses.end(), by_dof);

  own_.assign(surface_.pairs.size(), Eigen::Vector3d::Zero());
  coupled_start_.assign(1, 0);
  coupled_.clear();
  std::vector<std::size_t> place(surface_.pairs.size());
  std::vector<bool> met(surface_.pairs.size(), false);
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto rows = rows_of(surface_.pairs[i]);
    for (int k = 0; k < 3; ++k) {
      for (const auto& e : rows[static_cast<std::size_t>(k)]->entries) {
        const double moved = e.coefficient * states[static_cast<std::size_t>(e.part)].inverse_mass[e.dof];
        const auto [use, end] = std::equal_range(uses.begin(), uses.end(), Use{e.part, e.dof, 0, 0, 0.0}, by_dof);
        for (auto other = use; other != end; ++other) {
          if (!met[other->pair]) {
            met[other->pair] = true;
            place[other->pair] = coupled_.size();
            coupled_.push_back({other->pair, Eigen::Matrix3d::Zero()});
          }
          coupled_[place[other->pair]].inverse_mass(other->direction, k) += moved * other->coefficient;
        }
      }
    }
    for (std::size_t k = coupled_start_.back(); k < coupled_.size(); ++k) {
      met[coupled_[k].pair] = false;
      if (coupled_[k].pair == i) own_[i] = coupled_[k].inverse_mass.diagonal();
    }
    coupled_start_.push_back(coupled_.size());
  }
}

/// What a window leaves as it is while forces are sought, and the rates without any.
template <class Rate>
void ExplicitContact::prepare(const std::vector<BodyState>& states, Rate rate) {
  still_.resize(surface_.pairs.size());
  rates_.resize(surface_.pairs.size());
  for (std::size_t i = 0; i < still_.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    rates_[i] = {rate(pair.normal), rate(pair.tangent), rate(pair.binormal)};
    still_[i].gap = pair.gap(displacement_of(states));
    still_[i].inverse_n = pair.normal.inverse_mass(states);
    if (pair.friction_coefficient > 0.0) still_[i].inverse_along = pair.inverse_mass_along(states);
  }
}

double ExplicitContact::normal_force(std::size_t i, double rate_n, double acting_time) const {
  if (massless_) return state_.static_normal_n[static_cast<Eigen::Index>(i)];
  const double gap_now = still_[i].gap, inverse = still_[i].inverse_n;
  if (law_->enforcement == scene::Enforcement::penalty)
    return law_->penalty_pa_m * surface_.pairs[i].area_m2 * std::max(0.0, -gap_now);
  return inverse > 0.0 ? std::max(0.0, -(gap_now + dt_ * rate_n)) / (dt_ * acting_time * inverse) : 0.0;
}

ExplicitContact::Force ExplicitContact::find_force(std::size_t i, const std::vector<BodyState>& states, double rate_n,
                                                   const Eigen::Vector2d& rate_along, double acting_time) const {
  const auto& pair = surface_.pairs[i];
  if (frozen_ == participant::FrozenContact::open) return {};
  if (frozen_) return holding_force(i, states, rate_n, rate_along, acting_time);
  Force force;
  force.normal = normal_force(i, rate_n, acting_time);
  if (force.normal == 0.0) return force;
  force.state = ContactState::slip;
  if (pair.friction_coefficient == 0.0) return force;
  const Eigen::Matrix2d inverse = acting_time * still_[i].inverse_along;
  const Eigen::Vector2d holding = solver::holding_of_pair(inverse, rate_along);
  force.tangential =
      solver::friction_of_pair(*law_, pair.friction_coefficient * force.normal, rate_along, holding, inverse);
  if (force.tangential == holding) force.state = ContactState::stick;
  return force;
}

/// Frozen sticking: the linear part of `find_force`, normally and (with friction) tangentially.
ExplicitContact::Force ExplicitContact::holding_force(std::size_t i, const std::vector<BodyState>& states,
                                                      double rate_n, const Eigen::Vector2d& rate_along,
                                                      double acting_time) const {
  const auto& pair = surface_.pairs[i];
  const bool penalty = law_->enforcement == scene::Enforcement::penalty;
  const double moved_n = pair.normal.times(displacement_of(states)), inverse_n = still_[i].inverse_n;
  Force force{.normal = 0.0, .state = ContactState::stick};
  if (penalty) {
    force.normal = -law_->penalty_pa_m * pair.area_m2 * moved_n;
  } else if (inverse_n > 0.0) {
    force.normal = -(moved_n + dt_ * rate_n) / (dt_ * acting_time * inverse_n);
  }
  if (pair.friction_coefficient == 0.0) return force;
  const Eigen::Vector2d slipped = pair.slip(displacement_of(states)) + dt_ * rate_along;
  force.tangential = solver::holding_of_pair(dt_ * acting_time * still_[i].inverse_along, slipped);
  return force;
}

void ExplicitContact::push(const Pair& pair, const Force& force, std::vector<BodyState>& states) const {
  pair.normal.push(force.normal, states, push_accelerations(states));
  pair.push_along(force.tangential, states, push_accelerations(states));
}

double ExplicitContact::account(const Pair& pair, const Force& mean, std::vector<BodyState>& states,
                                const std::vector<const Eigen::VectorXd*>& u_before) {
  const auto moved = [&](const ContactRow& row) {
    return row.times(displacement_of(states)) - row.times(before_of(u_before));
  };
  const double made = mean.normal * moved(pair.normal);
  state_.work_normal_j += made;
  double taken = mean.tangential[0] * moved(pair.tangent);
  if (surface_.components == 3) taken += mean.tangential[1] * moved(pair.binormal);
  state_.dissipated_friction_j -= taken;
  solver::book_impulse(pair, dt_ * mean.normal, dt_ * mean.tangential, states, state_.impulses);
  return made;
}

/// After the normal impulse of the window has changed: the friction impulse stays within its cone and, of a slipping
/// pair that this does not turn around, on it. It keeps its direction e.
void ExplicitContact::clip_friction(std::size_t i, std::vector<BodyState>& states) {
  const auto& pair = surface_.pairs[i];
  Eigen::Vector2d& force = state_.mean_forces[i].tangential;
  const double mean = std::hypot(force[0], force[1]);
  if (mean == 0.0) return;
  const Eigen::Vector2d e = force / mean;
  const double limit = pair.friction_coefficient * state_.mean_forces[i].normal,
               inverse = e.dot(pair.inverse_mass_along(states) * e);
  const double target = state_.mean_forces[i].state == ContactState::slip ? limit : std::min(mean, limit);
  if (target == mean || inverse == 0.0) return;
  const double rate = e.dot(pair.slip(velocity_of(states)));
  double impulse = dt_ * (target - mean);
  if (target > mean && (rate + inverse * impulse) * rate < 0.0) impulse = -rate / inverse;
  pair.push_along(impulse * e, states, push_velocities(states));
  state_.dissipated_friction_j -= impulse * (rate + 0.5 * impulse * inverse);
  solver::book_impulse(pair, 0.0, impulse * e, states, state_.impulses);
  force += impulse / dt_ * e;
}

void ExplicitContact::finish(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  if (!massless_) return;
  massless_->for_each_dof(
      [&](std::size_t part, int dof) { states[part].v[dof] = (states[part].u[dof] - (*u_before[part])[dof]) / dt_; });
  velocity_of_part_.clear();
  for (auto& state : states) velocity_of_part_.push_back(state.v.data());
  massless_->begin_trial();
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const double impulse =
        massless_->give_back(i, made_j_[i], dt_ * state_.mean_forces[i].normal, states, velocity_of_part_);
    state_.mean_forces[i].normal += impulse / dt_;
    solver::book_impulse(surface_.pairs[i], impulse, Eigen::Vector2d::Zero(), states, state_.impulses);
    clip_friction(i, states);
  }
  state_.work_normal_j += massless_->trial_work_j();
  massless_->accept();
}

/// dt^2/8 a^T M a of a pair's nodes: what the staggered metric takes off 1/2 v^T M v. A contact force at n = 0 changes
/// it at once; that change is the energy an impact at the start costs.
double ExplicitContact::staggered_correction(const Pair& pair, const std::vector<BodyState>& states) const {
  double sum = 0.0;
  const auto has = [](const ContactRow& row, const solver::RowEntry& e) {
    return std::any_of(row.entries.begin(), row.entries.end(),
                       [&](const auto& n) { return n.part == e.part && n.dof == e.dof; });
  };
  for (const auto* row : {&pair.normal, &pair.tangent, &pair.binormal}) {
    for (const auto& e : row->entries) {
      const bool counted = (row != &pair.normal && has(pair.normal, e)) ||  // where n is along no coordinate
                           (row == &pair.binormal && has(pair.tangent, e));
      const auto& state = states[static_cast<std::size_t>(e.part)];
      if (!counted) sum += 0.125 * dt_ * dt_ * state.mass[e.dof] * state.a[e.dof] * state.a[e.dof];
    }
  }
  return sum;
}

/// From no forces; `rate` of a row with the accelerations so far, to which a force adds over `acting_time`. Pairs that
/// share nodes are gone through until no force changes.
template <class Rate>
void ExplicitContact::find_forces(const std::vector<BodyState>& states, Rate rate, double acting_time) {
  auto& forces = state_.forces;
  prepare(states, rate);
  for (std::size_t i = 0; i < forces.size(); ++i) forces[i] = {};
  if (!shared_) {
    for (std::size_t i = 0; i < forces.size(); ++i)
      forces[i] = find_force(i, states, rates_[i][0], rates_[i].tail<2>(), acting_time);
    return;
  }
  if (coupled_start_.empty()) couple_pairs(states);
  double change = 1.0, largest = 1.0;
  int sweep = 0;
  for (; change > solver::settled_share * largest && sweep < solver::most_sweeps; ++sweep) {
    change = largest = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      const Eigen::Vector3d before = vector_of(forces[i]),
                            without = rates_[i] - acting_time * own_[i].cwiseProduct(before);
      forces[i] = find_force(i, states, without[0], without.tail<2>(), acting_time);
      const Eigen::Vector3d more = vector_of(forces[i]) - before;
      largest = std::max(largest, std::abs(forces[i].normal));
      if (more.isZero(0.0)) continue;
      change = std::max(change, more.cwiseAbs().maxCoeff());
      for (std::size_t k = coupled_start_[i]; k < coupled_start_[i + 1]; ++k)
        rates_[coupled_[k].pair] += acting_time * (coupled_[k].inverse_mass * more);
    }
  }
  const double residual = largest > 0.0 ? change / largest : 0.0;
  state_.iterations += sweep;
  state_.largest_residual = std::max(state_.largest_residual, residual);
  state_.unconverged += residual > solver::converged_contact_residual;
}

void ExplicitContact::start(std::vector<BodyState>& states) {
  const auto rate = [&](const ContactRow& row) {
    return row.times(velocity_of(states)) + 0.5 * dt_ * row.times(acceleration_of(states));
  };
  find_forces(states, rate, 0.5 * dt_);
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const double before = staggered_correction(surface_.pairs[i], states);
    push(surface_.pairs[i], state_.forces[i], states);
    state_.work_normal_j -= staggered_correction(surface_.pairs[i], states) - before;
  }
}

/// Where the rows are written anew, the forces of n - 1 are accounted along those they acted along: half of the window
/// that ended at n. Returns whether they were.
bool ExplicitContact::follow(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  if (!sliding_ || frozen_) return false;
  const std::vector<Pair> old = surface_.pairs;
  if (!sliding_->follow(states, 0.0, surface_.pairs)) return false;
  shared_ = true;
  coupled_start_.clear();
  for (std::size_t i = 0; i < old.size(); ++i) {
    const Force& force = old_forces_[i];
    account(old[i], {.normal = 0.5 * force.normal, .tangential = 0.5 * force.tangential}, states, u_before);
  }
  const std::vector<int> same = solver::same_pairs(old, surface_.pairs);
  old_forces_ = solver::carried(same, old_forces_);
  state_.forces = solver::carried(same, state_.forces);
  state_.mean_forces = solver::carried(same, state_.mean_forces);
  return true;
}

void ExplicitContact::apply(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  old_forces_ = state_.forces;
  const bool followed = follow(states, u_before);
  const auto rate = [&](const ContactRow& row) {
    const double half_velocity = (row.times(displacement_of(states)) - row.times(before_of(u_before))) / dt_;
    return half_velocity + dt_ * row.times(acceleration_of(states));
  };
  find_forces(states, rate, dt_);
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) push(surface_.pairs[i], state_.forces[i], states);
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const Force &old = old_forces_[i], &now = state_.forces[i];
    state_.mean_forces[i] = {.normal = 0.5 * (old.normal + now.normal),
                             .tangential = 0.5 * (old.tangential + now.tangential),
                             .state = now.state};
    Force accounted = state_.mean_forces[i];
    if (followed) accounted = {.normal = 0.5 * now.normal, .tangential = 0.5 * now.tangential};
    const double made = account(surface_.pairs[i], accounted, states, u_before);
    if (massless_) made_j_[i] = made;
  }
}

int ExplicitContact::pairs_closed() const {
  return static_cast<int>(std::count_if(state_.forces.begin(), state_.forces.end(),
                                        [](const Force& f) { return f.state != ContactState::open; }));
}

ExplicitContact::State ExplicitContact::state() const {
  State state = state_;
  if (massless_) state.massless = massless_->state();
  if (sliding_) state.sliding = sliding_->state();
  return state;
}

void ExplicitContact::restore(const State& state) {
  state_ = state;
  if (sliding_) {
    sliding_->restore(state.sliding, surface_.pairs);
    coupled_start_.clear();
  }
  for (const auto* forces : {&state.forces, &state.mean_forces}) surface_.require_one_a_pair(forces->size());
  if (massless_) massless_->restore(*state.massless);
}

const ContactRecord& ExplicitContact::report(const std::vector<BodyState>& states) {
  surface_.report(states, state_.mean_forces, state_, report_);
  return report_;
}

}  // namespace ricochet::explicit_solver
