#include "explicit_solver/explicit_contact.hpp"

#include <algorithm>
#include <utility>

#include "common/contact/pair_compliance.hpp"

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

}  // namespace

ExplicitContact::ExplicitContact(const scene::Contact& law, solver::ContactSurface surface, const WindowClock& clock,
                                 std::optional<solver::SlidingRows> sliding)
    : law_(&law), clock_(clock), surface_(std::move(surface)), sliding_(std::move(sliding)) {
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
  if (!massless_) return;
  state_.static_normal_n = massless_->settle(
      states, [&](std::size_t part) -> const Eigen::VectorXd& { return *external[part]; },
      [&](std::size_t part) -> Eigen::VectorXd& { return *u[part]; });
}

/// In a window a force r changes the rates by acting_time N M^-1 N^T r and the gaps by dt times that: x = dt
/// acting_time r are the forces of the root problem. Its slip is dt times a rate, and its v is 2/dt slip. A rigid body
/// couples all pairs, so that the matrix is full, and sweeps would go on for long.
void ExplicitContact::make_root(const std::vector<BodyState>& states) {
  const auto friction = [](const Pair& pair) { return pair.friction_coefficient > 0.0; };
  const bool any = std::any_of(surface_.pairs.begin(), surface_.pairs.end(), friction);
  scene::Contact law = *law_;
  law.enforcement = scene::Enforcement::multiplier;  // a penalty's normal forces are known
  std::vector<solver::RootProblem::PairLaw> pairs;
  for (const auto& pair : surface_.pairs) pairs.push_back({pair.area_m2, pair.friction_coefficient});
  const Eigen::Index directions = any ? surface_.components : 1;
  const bool rigid =
      std::any_of(states.begin(), states.end(), [](const BodyState& state) { return state.part.mesh.rigid_nodes > 0; });
  solver::Compliance compliance =
      responses_ ? solver::compliance_of(surface_.pairs, *responses_, state_.turns, surface_.components, directions)
                 : solver::inverse_mass_of(surface_.pairs, states, directions);
  if (rigid && compliance.sparse()) compliance = Eigen::MatrixXd(*compliance.sparse());
  root_.emplace(law, std::move(compliance), pairs, 2.0 * dt());
}

/// Gaps and slips at the end of the window without contact forces; of held pairs both from zero.
template <class Rate>
void ExplicitContact::find_free_motion(const std::vector<BodyState>& states, Rate rate) {
  const auto n = static_cast<Eigen::Index>(pairs());
  gap_free_.setZero(n);
  slip_free_.setZero(2 * n);
  for (std::size_t i = 0; i < pairs(); ++i) {
    const auto& pair = surface_.pairs[i];
    const auto k = static_cast<Eigen::Index>(i);
    gap_free_[k] = dt() * rate(pair.normal);
    gap_free_[k] += frozen_ ? pair.normal.times(displacement_of(states)) : pair.gap(displacement_of(states));
    if (pair.friction_coefficient == 0.0) continue;
    Eigen::Vector2d slip = dt() * Eigen::Vector2d(rate(pair.tangent), rate(pair.binormal));
    if (frozen_) slip += pair.slip(displacement_of(states));
    slip_free_[k] = slip[0];
    slip_free_[n + k] = slip[1];
  }
}

/// For a penalty, and for massless nodes: their normal forces, as those of the root problem.
void ExplicitContact::find_known_normals(const std::vector<BodyState>& states, double acting_time) {
  known_normal_.resize(0);
  if (law_->enforcement == scene::Enforcement::penalty) {
    known_normal_.resize(gap_free_.size());
    for (std::size_t i = 0; i < pairs(); ++i) {
      const auto& pair = surface_.pairs[i];
      const double depth =
          frozen_ ? -pair.normal.times(displacement_of(states)) : std::max(0.0, -pair.gap(displacement_of(states)));
      known_normal_[static_cast<Eigen::Index>(i)] = law_->penalty_pa_m * pair.area_m2 * depth;
    }
  } else if (massless_ && !frozen_) {
    known_normal_ = state_.static_normal_n;
  }
  known_normal_ *= dt() * acting_time;
}

void ExplicitContact::push(const Pair& pair, const Force& force, std::vector<BodyState>& states) const {
  pair.normal.push(force.normal, states, push_accelerations(states));
  pair.push_along(force.tangential, states, push_accelerations(states));
}

/// The forces of the window before as a solution to start from.
solver::RootProblem::Solution ExplicitContact::last_forces(double acting_time) const {
  auto last = root_->open();
  const auto n = static_cast<Eigen::Index>(pairs());
  for (std::size_t i = 0; i < pairs(); ++i) {
    const auto& force = state_.forces[i];
    const double of[3] = {force.normal, force.tangential[0], force.tangential[1]};
    for (Eigen::Index d = 0; d * n < last.force.size(); ++d)
      last.force[d * n + static_cast<Eigen::Index>(i)] = of[d] * dt() * acting_time;
    last.states[i] = force.state;
  }
  return last;
}

/// Adds a share of what the forces do to the accelerations.
void ExplicitContact::push_all(double share, std::vector<BodyState>& states) {
  if (inside_small_steps()) {
    for (std::size_t b = 0; b < states.size(); ++b)
      states[b].a += share * states[b].inverse_mass.cwiseProduct(spread_[b]);
    return;
  }
  for (std::size_t i = 0; i < pairs(); ++i) {
    const Force& force = state_.forces[i];
    push(surface_.pairs[i], {.normal = share * force.normal, .tangential = share * force.tangential}, states);
  }
}

const solver::RootProblem::Solution& ExplicitContact::solution(double acting_time) {
  if (root_->compliance().dense() == nullptr || (known_normal_.size() > 0 && !inside_small_steps()))
    return root_->sweep_from_none(gap_free_, slip_free_, known_normal_, frozen_.has_value());
  if (frozen_) return root_->hold(gap_free_, slip_free_);
  return root_->solve(gap_free_, slip_free_, Eigen::VectorXd::Zero(slip_free_.size()), last_forces(acting_time));
}

/// `rate` of a row with the accelerations so far, to which a force adds over `acting_time`.
template <class Rate>
void ExplicitContact::find_forces(const std::vector<BodyState>& states, Rate rate, double acting_time, bool anew) {
  auto& forces = state_.forces;
  if (frozen_ == participant::FrozenContact::open || forces.empty()) {
    std::fill(forces.begin(), forces.end(), Force{});
    return;
  }
  find_free_motion(states, rate);
  if (turned()) {
    root_.reset();
    anew = true;
    if (gap_free_.minCoeff() > 0.0) {  // a flight needs no compliance
      std::fill(forces.begin(), forces.end(), Force{});
      return;
    }
  }
  if (anew) note_turns();
  if (!root_) make_root(states);
  if (!anew && !state_.turns.empty()) add_turn(states, acting_time);
  find_known_normals(states, acting_time);
  const auto& found = solution(acting_time);
  const auto n = static_cast<Eigen::Index>(pairs()), size = found.force.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto of = [&](Eigen::Index d) { return d * n < size ? found.force[d * n + i] / (dt() * acting_time) : 0.0; };
    const auto k = static_cast<std::size_t>(i);
    forces[k] = {.normal = of(0), .tangential = {of(1), of(2)}, .state = found.states[k]};
  }
  state_.iterations += found.iterations;
  state_.largest_residual = std::max(state_.largest_residual, found.residual);
  state_.unconverged += found.residual > solver::converged_contact_residual;
}

void ExplicitContact::start(std::vector<BodyState>& states) {
  const auto rate = [&](const ContactRow& row) {
    return row.times(velocity_of(states)) + 0.5 * dt() * row.times(acceleration_of(states));
  };
  find_forces(states, rate, 0.5 * dt(), true);
  if (inside_small_steps()) spread_forces();
  act(1.0, states);
}

void ExplicitContact::act(double share, std::vector<BodyState>& states) {
  if (inside_small_steps()) {
    const double before = staggered_correction(states);
    push_all(share, states);
    state_.work_normal_j -= staggered_correction(states) - before;
    return;
  }
  for (std::size_t i = 0; i < pairs(); ++i) {
    const Force& force = state_.forces[i];
    const double before = staggered_correction(surface_.pairs[i], states);
    push(surface_.pairs[i], {.normal = share * force.normal, .tangential = share * force.tangential}, states);
    state_.work_normal_j -= staggered_correction(surface_.pairs[i], states) - before;
  }
}

void ExplicitContact::reconfigure(std::vector<BodyState>& states) {
  root_.reset();
  act(-1.0, states);
  start(states);
}

/// Where the rows are written anew, the forces of n - 1 are accounted along those they acted along: half of the window
/// that ended at n. Returns whether they were.
bool ExplicitContact::follow(std::vector<BodyState>& states, const std::vector<const Eigen::VectorXd*>& u_before) {
  if (!sliding_ || frozen_) return false;
  const std::vector<Pair> old = surface_.pairs;
  if (!sliding_->follow(states, 0.0, -0.5 * dt(), state_.mean_forces, surface_.pairs)) return false;
  root_.reset();
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
    const double half_velocity = (row.times(displacement_of(states)) - row.times(before_of(u_before))) / dt();
    return half_velocity + dt() * row.times(acceleration_of(states));
  };
  find_forces(states, rate, dt(), followed);
  if (inside_small_steps()) {
    old_spread_.swap(spread_);
    spread_forces();
  }
  push_all(1.0, states);
  const double dissipated_before_j = state_.dissipated_friction_j;
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
  if (inside_small_steps())
    state_.work_normal_j += work_inside(states, u_before) + (state_.dissipated_friction_j - dissipated_before_j);
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
    root_.reset();
  }
  for (const auto* forces : {&state.forces, &state.mean_forces}) surface_.require_one_a_pair(forces->size());
  if (massless_) massless_->restore(*state.massless);
  if (inside_small_steps()) spread_forces();
}

const ContactRecord& ExplicitContact::report(const std::vector<BodyState>& states, double unspread_j) {
  surface_.report(states, state_.mean_forces, state_, report_);
  report_.energy_contact_j += unspread_j;
  return report_;
}

}  // namespace ricochet::explicit_solver
