// The part of ImplicitContact for pairs that share nodes, as a node that lies against an edge does with its neighbours.
#include <algorithm>
#include <cmath>

#include "common/solver/friction.hpp"
#include "implicit_solver/contact/implicit_contact.hpp"

namespace ricochet::implicit_solver {

using solver::BodyState;
using solver::ContactState;

/// Impulses and rates as the class comment has them. A pair's force at n is what its acceleration remembered then, at
/// n + 1 kappa r; the jumps of all closed pairs together leave no relative velocity, the remembered forces no relative
/// acceleration but where that would take a pull.
void ImplicitContact::update_shared(const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                    Eigen::VectorXd& acceleration) {
  const std::size_t pairs = surface_.pairs.size();
  for (std::size_t i = 0; i < pairs; ++i) {
    const double normal = trial_.force[static_cast<Eigen::Index>(i)];
    const Eigen::Vector2d tangential = along_surface(i, trial_.force);
    const auto& before = state_.remembered[i];
    impulse_[i] = {.normal = 0.5 * dt_ * (before.normal + kappa() * normal),
                   .tangential = 0.5 * dt_ * (before.tangential + kappa() * tangential),
                   .state = trial_.states[i]};
    remembered_[i] = trial_memory(i);
    jump_impulse_[i] = {};
  }
  if (frozen_) {
    if (held()) hold_means(states, velocity, acceleration);
    return;
  }
  if (!resets()) return;
  double change = 1.0, largest = 1.0;
  int sweep = 0;
  for (; change > solver::settled_share * largest && sweep < solver::most_sweeps; ++sweep) {
    change = largest = 0.0;
    for (std::size_t i = 0; i < pairs; ++i) {
      if (trial_.states[i] != ContactState::open) {
        change = std::max(change, reset_shared(i, states, velocity, acceleration));
      } else if (surface_.pairs[i].friction_coefficient > 0.0) {
        const Eigen::Vector2d before = impulse_[i].tangential;
        clip_tangent(i, states, velocity);
        const Eigen::Vector2d taken = impulse_[i].tangential - before;
        jump_impulse_[i].tangential += taken;
        change = std::max(change, taken.cwiseAbs().maxCoeff());
      }
      largest = std::max({largest, std::abs(impulse_[i].normal), dt_ * remembered_[i].normal});
    }
  }
  trial_.iterations += sweep;
  if (largest > 0.0) trial_.residual = std::max(trial_.residual, change / largest);
}

/// One closed pair, all others being right; returns the largest change of an impulse [N s].
double ImplicitContact::reset_shared(std::size_t i, const std::vector<BodyState>& states, Eigen::VectorXd& velocity,
                                     Eigen::VectorXd& acceleration) {
  const auto& pair = surface_.pairs[i];
  const double inverse = pair.normal.inverse_mass(states);
  double change = 0.0;
  if (inverse > 0.0) {
    const double jump = -pair.normal.times(of_part(velocity)) / inverse;
    push(pair, states, along_normal, jump, velocity);
    impulse_[i].normal += jump;
    jump_impulse_[i].normal += jump;
    double& remembered = remembered_[i].normal;
    const double force = std::max(0.0, remembered - pair.normal.times(of_part(acceleration)) / inverse);
    push(pair, states, along_normal, force - remembered, acceleration);
    change = std::max(std::abs(jump), dt_ * std::abs(force - remembered));
    remembered = force;
  }
  if (pair.friction_coefficient == 0.0) return change;
  return std::max(change, reset_shared_tangent(i, states, velocity, acceleration));
}

/// As `reset_tangent`.
double ImplicitContact::reset_shared_tangent(std::size_t i, const std::vector<BodyState>& states,
                                             Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration) {
  const auto& pair = surface_.pairs[i];
  const Eigen::Matrix2d inverse = pair.inverse_mass_along(states);
  if (inverse.isZero(0.0)) return 0.0;
  auto& impulse = impulse_[i];
  const Friction friction = friction_impulse(pair, inverse, impulse, pair.slip(of_part(velocity)));
  const Eigen::Vector2d jump = friction.given - impulse.tangential;
  pair.push_along(jump, states, of_part(velocity));
  impulse.tangential = friction.given;
  jump_impulse_[i].tangential += jump;
  impulse.state = friction.sticks ? ContactState::stick : ContactState::slip;
  Eigen::Vector2d& remembered = remembered_[i].tangential;
  const Eigen::Vector2d force =
      remembered_friction(pair, friction, inverse, remembered_[i].normal, remembered, pair.slip(of_part(acceleration)));
  const Eigen::Vector2d taken = force - remembered;
  pair.push_along(taken, states, of_part(acceleration));
  remembered = force;
  return std::max(jump.cwiseAbs().maxCoeff(), dt_ * taken.cwiseAbs().maxCoeff());
}

/// Work of the forces at n and n + 1 over the increment, and of the jumps. Where rows were written anew, those at n
/// acted along the rows before.
void ImplicitContact::account_shared(std::vector<BodyState>& states, const Eigen::VectorXd& increment,
                                     const Eigen::VectorXd& mean_velocity) {
  for (std::size_t i = 0; i < surface_.pairs.size(); ++i) {
    const auto& pair = surface_.pairs[i];
    const auto work = [&](const solver::ContactRow& row, double impulse, double jump) {
      return (impulse - jump) / dt_ * row.times(of_part(increment)) + jump * row.times(of_part(mean_velocity));
    };
    solver::PairForce own = impulse_[i];
    if (!old_pairs_.empty()) {
      own.normal -= 0.5 * dt_ * state_.remembered[i].normal;
      own.tangential -= 0.5 * dt_ * state_.remembered[i].tangential;
    }
    state_.work_normal_j += work(pair.normal, own.normal, jump_impulse_[i].normal);
    state_.dissipated_friction_j -= work(pair.tangent, own.tangential[0], jump_impulse_[i].tangential[0]);
    state_.dissipated_friction_j -= work(pair.binormal, own.tangential[1], jump_impulse_[i].tangential[1]);
    book_impulse(pair, own.normal, own.tangential, states, state_.impulses);
  }
  for (std::size_t i = 0; i < old_pairs_.size(); ++i) {
    const auto& pair = old_pairs_[i];
    const double normal = 0.5 * dt_ * old_remembered_[i].normal;
    const Eigen::Vector2d along = 0.5 * dt_ * old_remembered_[i].tangential,
                          slipped = pair.slip(of_part(increment)) / dt_;
    state_.work_normal_j += normal / dt_ * pair.normal.times(of_part(increment));
    state_.dissipated_friction_j -= along.dot(slipped);
    book_impulse(pair, normal, along, states, state_.impulses);
  }
}

}  // namespace ricochet::implicit_solver
