// The part of ImplicitContact for what a window leaves: velocities and accelerations of closed pairs, work and
// impulses.
#include <algorithm>
#include <cmath>

#include "common/contact/friction.hpp"
#include "common/fem/element.hpp"
#include "implicit_solver/contact/implicit_contact.hpp"

namespace ricochet::implicit_solver {

using solver::BodyState;
using solver::ContactState;
using solver::Pair;
using solver::PairForce;
using solver::row_of;
using solver::Side;

namespace {

double& component(PairForce& force, Eigen::Index direction) {
  return direction == 0 ? force.normal : force.tangential[direction - 1];
}

}  // namespace

void ImplicitContact::find_inverse_mass(const std::vector<BodyState>& states) {
  if (!inverse_mass_) inverse_mass_ = solver::inverse_mass_of(surface_.pairs, states, directions());
}

/// T M^-1 T^T [1/kg]
Eigen::Matrix2d ImplicitContact::inverse_mass_along(std::size_t i) const {
  Eigen::Matrix2d along = Eigen::Matrix2d::Zero();
  for (Eigen::Index d = 1; d < directions(); ++d) along(d - 1, d - 1) = inverse_mass_->alone(unknown(i, d));
  if (directions() == 3) along(0, 1) = along(1, 0) = inverse_mass_->entry(unknown(i, 1), unknown(i, 2));
  return along;
}

/// Forces or impulses that are in rates, and the relative rates of closed pairs, or of all.
void ImplicitContact::begin_sweep(const std::vector<PairForce>& forces, const Eigen::VectorXd& values, bool of_all) {
  sweep_.x.resize(unknown(0, directions()));
  sweep_.motion.setZero(sweep_.x.size());
  for (std::size_t i = 0; i < pairs(); ++i) {
    const bool moves = of_all || closed(i);
    for (Eigen::Index d = 0; d < directions(); ++d) {
      sweep_.x[unknown(i, d)] = d == 0 ? forces[i].normal : forces[i].tangential[d - 1];
      if (moves) sweep_.motion[unknown(i, d)] = row_of(surface_.pairs[i], d).times(of_part(values));
    }
  }
  sweep_.x_before = sweep_.x;
}

template <class Project>
void ImplicitContact::run_sweep(const Project& project) {
  const auto swept =
      solver::sweep(*inverse_mass_, static_cast<int>(pairs()), solver::most_sweeps, sweep_.x, sweep_.motion, project);
  trial_.solution.residual = std::max(trial_.solution.residual, swept.residual);
}

/// M^-1 N^T times what the sweep has added.
void ImplicitContact::push_swept(const std::vector<BodyState>& states, Eigen::VectorXd& values) const {
  for (std::size_t i = 0; i < pairs(); ++i) {
    for (Eigen::Index d = 0; d < directions(); ++d) {
      const double more = sweep_.x[unknown(i, d)] - sweep_.x_before[unknown(i, d)];
      if (more != 0.0) row_of(surface_.pairs[i], d).push(more, states, of_part(values));
    }
  }
}

/// Eq. 25-27 against the mean by masses: weights rho C, longitudinal along n, shear along the surface.
ImplicitContact::Impedance ImplicitContact::impedance_of(const Pair& pair, const std::vector<BodyState>& states,
                                                         Eigen::Index direction) const {
  const auto& row = row_of(pair, direction);
  const double wa = row.inverse_mass_of(Side::a, states), wb = row.inverse_mass_of(Side::b, states);
  if (!by_impedance() || wa == 0.0 || wb == 0.0) return {};
  const auto impedance = [&](int part) {
    const auto& body = problem_->bodies[static_cast<std::size_t>(states[static_cast<std::size_t>(part)].body)];
    const double speed = direction == 0 ? fem::longitudinal_wave_speed(problem_->scene.model, body.material)
                                        : fem::shear_wave_speed(body.material);
    return body.material.density_kg_m3 * speed;
  };
  const double za = impedance(row.part_of(Side::a)), zb = impedance(row.part_of(Side::b));
  const double share_a = zb / (za + zb), share_b = za / (za + zb);  // of a relative rate, by which A and B move
  return {share_a - wa / (wa + wb), 0.5 * (wa + wb) * (share_a / wa + share_b / wb)};
}

/// A pair whose relative rate an impulse (or force) `taken` on B took, by masses: moves both sides to the mean by
/// impedances. `uneven` is what both then got beside the impulse that is returned, the mean of their own.
double ImplicitContact::move_both(const Pair& pair, const std::vector<BodyState>& states, Eigen::Index direction,
                                  double taken, double& uneven, Eigen::VectorXd& values) const {
  const Impedance impedance = impedance_of(pair, states, direction);
  const auto& row = row_of(pair, direction);
  const double wa = row.inverse_mass_of(Side::a, states), wb = row.inverse_mass_of(Side::b, states);
  const double moved = -impedance.moves * taken * (wa + wb);
  if (moved == 0.0) return taken;
  for (const auto& e : row.entries) {
    const bool a = e.side == Side::a;
    const double inverse = states[static_cast<std::size_t>(e.part)].inverse_mass[e.dof];
    of_part(values)(e.part)[e.dof] += (a ? -moved / wa : moved / wb) * e.coefficient * inverse;
  }
  uneven = 0.5 * moved * (1.0 / wa + 1.0 / wb);
  return impedance.gain * taken;
}

/// Rates of held pairs: linear, whatever the sign of a force.
void ImplicitContact::hold_means(const std::vector<BodyState>& states, Eigen::VectorXd& values) {
  if (!resets() || pairs() == 0) return;
  find_inverse_mass(states);
  begin_sweep(std::vector<PairForce>(pairs()), values, true);
  const auto hold = [&](int pair, const auto& set) {
    const auto i = static_cast<std::size_t>(pair);
    const Eigen::Index own = surface_.pairs[i].friction_coefficient > 0.0 ? directions() : 1;
    for (Eigen::Index d = 0; d < own; ++d) {
      const Eigen::Index k = unknown(i, d);
      if (inverse_mass_->alone(k) > 0.0) set(k, sweep_.x[k] - sweep_.motion[k] / inverse_mass_->alone(k));
    }
  };
  run_sweep(hold);
  push_swept(states, values);
  double uneven = 0.0;
  for (std::size_t i = 0; by_impedance() && i < pairs(); ++i)
    for (Eigen::Index d = 0; d < directions(); ++d)
      move_both(surface_.pairs[i], states, d, sweep_.x[unknown(i, d)], uneven, values);
}

/// With a penalty the force of the present gap is part of the acceleration that the law remembers; a multiplier either
/// is not remembered or cancels in the mean.
void ImplicitContact::hold_rates(const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                 Eigen::VectorXd& acceleration) {
  find_moved(states, Eigen::VectorXd::Zero(velocity.size()));
  trial_.solution = root_->spring(free_.gap, free_.slip);
  for (std::size_t i = 0; i < pairs(); ++i) {
    for (Eigen::Index d = 0; d < directions(); ++d)
      row_of(surface_.pairs[i], d).push(trial_.solution.force[unknown(i, d)], states, of_part(acceleration));
  }
  hold_means(states, velocity);
  hold_means(states, acceleration);
}

/// Whether friction may act on a closed pair.
bool ImplicitContact::slides(std::size_t i) const {
  return closed(i) && surface_.pairs[i].friction_coefficient > 0.0 && !inverse_mass_along(i).isZero(0.0);
}

/// mu times the normal force or impulse of the present sweep, as it is told.
double ImplicitContact::friction_limit(std::size_t i, const std::vector<BodyState>& states) const {
  const auto& pair = surface_.pairs[i];
  const double before = sweep_.x_before[unknown(i, 0)], normal = sweep_.x[unknown(i, 0)];
  const double told = by_impedance() ? before + impedance_of(pair, states, 0).gain * (normal - before) : normal;
  return pair.friction_coefficient * std::max(0.0, told);
}

/// The impulse along the surface of a closed pair, of the present sweep: what holds it, clipped to the cone of the
/// normal impulse.
ImplicitContact::Friction ImplicitContact::friction_impulse(std::size_t i, const std::vector<BodyState>& states) const {
  const Eigen::Matrix2d inverse = inverse_mass_along(i);
  const Eigen::Vector2d free_rate = along_surface(i, sweep_.motion) - inverse * along_surface(i, sweep_.x);
  const Eigen::Vector2d holding = solver::holding_of_pair(inverse, free_rate);
  Friction friction;
  friction.limit = friction_limit(i, states);
  friction.given = solver::friction_of_pair(law(), friction.limit, free_rate, holding, inverse);
  friction.sticks = friction.given == holding;
  return friction;
}

/// The force that the acceleration then remembers, likewise.
Eigen::Vector2d ImplicitContact::remembered_friction(std::size_t i, const std::vector<BodyState>& states,
                                                     Friction& friction) const {
  const double limit = friction_limit(i, states);
  if (friction.sticks) {
    const Eigen::Vector2d holding =
        along_surface(i, sweep_.x) + solver::holding_of_pair(inverse_mass_along(i), along_surface(i, sweep_.motion));
    const Eigen::Vector2d force = solver::clip_to_cone(holding, limit);
    friction.stays = force == holding;
    return force;
  }
  if (!(friction.limit > 0.0)) return Eigen::Vector2d::Zero();
  return limit * friction.given / friction.limit;
}

void ImplicitContact::update_rates(const std::vector<BodyState>& states, const Eigen::VectorXd& increment,
                                   Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration) {
  trial_.start(pairs(), by_impedance());
  for (std::size_t i = 0; i < pairs(); ++i) {
    const PairForce now{.normal = trial_.solution.force[unknown(i, 0)],
                        .tangential = along_surface(i, trial_.solution.force)};
    const auto& before = state_.remembered[i];
    trial_.impulse[i] = {.normal = 0.5 * dt_ * (before.normal + kappa() * now.normal),
                         .tangential = 0.5 * dt_ * (before.tangential + kappa() * now.tangential),
                         .state = trial_.solution.states[i]};
    if (remembered()) trial_.remembered[i] = now;
  }
  if (frozen_) {
    if (!held()) return;
    hold_means(states, velocity);
    hold_means(states, acceleration);
    return;
  }
  if (massless_) give_back(states, increment, velocity);
  if (!resets() || pairs() == 0) return;
  find_inverse_mass(states);
  reset_velocities(states, velocity);
  reset_accelerations(states, acceleration);
}

/// The energy that closing and opening made in this window, back to the nodes that carry the mass.
void ImplicitContact::give_back(const std::vector<BodyState>& states, const Eigen::VectorXd& increment,
                                Eigen::VectorXd& velocity) {
  massless_->begin_trial();
  for (std::size_t i = 0; i < pairs(); ++i) {
    double& impulse = trial_.impulse[i].normal;
    const double made = impulse / dt_ * surface_.pairs[i].normal.times(of_part(increment));
    impulse += massless_->give_back(i, made, impulse, states,
                                    [&](std::size_t part) { return velocity.data() + offsets_[part]; });
  }
}

/// No relative velocity is left along the normal of a closed pair, and along its surface what its cone leaves; of one
/// that opened in this window what is left of its impulses stays within the cone, too. Nodes without mass along the
/// normal have no velocity to jump.
void ImplicitContact::reset_velocities(const std::vector<BodyState>& states, Eigen::VectorXd& velocity) {
  begin_sweep(trial_.impulse, velocity);
  const auto project = [&](int pair, const auto& set) {
    const auto i = static_cast<std::size_t>(pair);
    const Eigen::Index k = unknown(i, 0);
    const double inverse = inverse_mass_->alone(k), mu = surface_.pairs[i].friction_coefficient;
    if (closed(i) && !massless_ && inverse > 0.0) set(k, sweep_.x[k] - sweep_.motion[k] / inverse);
    if (mu == 0.0) return;
    Eigen::Vector2d given = solver::clip_to_cone(along_surface(i, sweep_.x), mu * std::max(0.0, sweep_.x[k]));
    if (closed(i)) {
      if (!slides(i)) return;
      trial_.friction[i] = friction_impulse(i, states);
      given = trial_.friction[i].given;
    }
    for (Eigen::Index d = 1; d < directions(); ++d) set(unknown(i, d), given[d - 1]);
  };
  run_sweep(project);
  push_swept(states, velocity);
  for (std::size_t i = 0; i < pairs(); ++i) {
    const bool sticks = trial_.friction[i].sticks;
    if (slides(i)) trial_.impulse[i].state = sticks ? ContactState::stick : ContactState::slip;
    for (Eigen::Index d = 0; d < directions(); ++d) {
      double jump = sweep_.x[unknown(i, d)] - sweep_.x_before[unknown(i, d)];
      if (by_impedance() && closed(i) && (d == 0 || sticks))
        jump = move_both(surface_.pairs[i], states, d, jump, trial_.uneven_jump[i][d], velocity);
      component(trial_.jump[i], d) = jump;
      component(trial_.impulse[i], d) += jump;
    }
  }
}

/// The forces that are remembered leave no relative acceleration, but where that would take a pull (which a mean by
/// impedances does) or more than friction gives.
void ImplicitContact::reset_accelerations(const std::vector<BodyState>& states, Eigen::VectorXd& acceleration) {
  begin_sweep(trial_.remembered, acceleration);
  const auto project = [&](int pair, const auto& set) {
    const auto i = static_cast<std::size_t>(pair);
    if (!closed(i)) return;
    const Eigen::Index k = unknown(i, 0);
    const double inverse = inverse_mass_->alone(k);
    if (!massless_ && inverse > 0.0) {
      const double force = sweep_.x[k] - sweep_.motion[k] / inverse;
      set(k, by_impedance() ? force : std::max(0.0, force));
    }
    if (!slides(i)) return;
    const Eigen::Vector2d along = remembered_friction(i, states, trial_.friction[i]);
    for (Eigen::Index d = 1; d < directions(); ++d) set(unknown(i, d), along[d - 1]);
  };
  run_sweep(project);
  push_swept(states, acceleration);
  for (std::size_t i = 0; i < pairs(); ++i) {
    for (Eigen::Index d = 0; d < directions(); ++d) {
      double more = sweep_.x[unknown(i, d)] - sweep_.x_before[unknown(i, d)];
      if (by_impedance() && closed(i) && (d == 0 || trial_.friction[i].stays))
        more = move_both(surface_.pairs[i], states, d, more, trial_.uneven[i][d], acceleration);
      component(trial_.remembered[i], d) += more;
    }
  }
}

/// Work of the forces at n and n + 1 over the increment, and of the jumps. Where rows were written anew, those at n
/// acted along the rows before.
void ImplicitContact::account(std::vector<BodyState>& states, const Eigen::VectorXd& increment,
                              const Eigen::VectorXd& mean_velocity) {
  if (massless_) {
    state_.work_normal_j += massless_->trial_work_j();
    massless_->accept();
  }
  const auto work = [&](const Pair& pair, const PairForce& impulse, const Eigen::VectorXd& moved, double dt) {
    if (impulse.normal == 0.0 && impulse.tangential.isZero(0.0)) return;
    state_.work_normal_j += impulse.normal / dt * pair.normal.times(of_part(moved));
    state_.dissipated_friction_j -= impulse.tangential.dot(pair.slip(of_part(moved))) / dt;
    const auto moved_of = [&](int part, int dof) { return of_part(moved)(part)[dof]; };
    book_given_motion(pair, impulse.normal / dt, impulse.tangential / dt, moved_of, states);
  };
  const auto middle = [&](int part, int dof) {
    return states[static_cast<std::size_t>(part)].u[dof] + 0.5 * of_part(increment)(part)[dof];
  };
  const double half = 0.5 * dt_;
  const auto& old_pairs = before_.pairs.empty() ? surface_.pairs : before_.pairs;
  const auto& old_forces = before_.pairs.empty() ? state_.remembered : before_.remembered;
  for (std::size_t i = 0; i < old_pairs.size(); ++i) {
    const PairForce at_n{.normal = half * old_forces[i].normal, .tangential = half * old_forces[i].tangential};
    work(old_pairs[i], at_n, increment, dt_);
    book_impulse(old_pairs[i], at_n.normal, at_n.tangential, middle, states, state_.impulses);
  }
  for (std::size_t i = 0; i < pairs(); ++i) {
    const auto& pair = surface_.pairs[i];
    const PairForce at_end{.normal = half * kappa() * trial_.solution.force[unknown(i, 0)],
                           .tangential = half * kappa() * along_surface(i, trial_.solution.force)};
    work(pair, at_end, increment, dt_);
    work(pair, trial_.jump[i], mean_velocity, 1.0);
    book_impulse(pair, trial_.impulse[i].normal - half * state_.remembered[i].normal,
                 trial_.impulse[i].tangential - half * state_.remembered[i].tangential, middle, states,
                 state_.impulses);
    if (!by_impedance()) continue;
    const auto both = [&](Eigen::Index d, const Eigen::VectorXd& moved) {
      return row_of(pair, d).of(Side::a, of_part(moved)) + row_of(pair, d).of(Side::b, of_part(moved));
    };
    for (Eigen::Index d = 0; d < directions(); ++d) {
      const double both_j =
          0.5 * state_.uneven[i][d] * both(d, increment) + trial_.uneven_jump[i][d] * both(d, mean_velocity);
      (d == 0 ? state_.work_normal_j : state_.dissipated_friction_j) += d == 0 ? both_j : -both_j;
    }
  }
}

}  // namespace ricochet::implicit_solver
