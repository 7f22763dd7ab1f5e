#pragma once

#include <Eigen/Core>

#include "common/body/body_state.hpp"
#include "common/fem/newmark.hpp"

/// One step of central difference on a part (Newmark, beta = 0, gamma = 1/2; Eq. 3-6):
///   u_{n+1} = u_n + dt v_n + dt^2/2 a_n,   M a_{n+1} = f_{n+1} - K u_{n+1},   v_{n+1} = v_n + dt/2 (a_n + a_{n+1})
/// f holds loads, the forces of dashpots and, at constrained degrees of freedom, the reactions M a + K u. The step in
/// pieces, since links and contacts come in between; u and v are newmark.hpp's.
namespace ricochet::solver {

/// u_{n+1} of the part's own degrees of freedom, at `time_s` = t_{n+1}.
inline void step_displacement(const BodyState& state, double time_s, double dt, const Eigen::VectorXd& u,
                              const Eigen::VectorXd& v, const Eigen::VectorXd& a, Eigen::VectorXd& next) {
  next = fem::predicted_displacement(u, v, a, dt, fem::beta_explicit);
  state.constrain_displacement(time_s, next);
}

/// The dashpots' forces at t_{n+1} join `external`. `half_velocity(dof)`: v_{n+1/2}; `others(dof, load)`: all forces on
/// the mass but the dashpot's, of which the load is one.
template <class External, class HalfVelocity, class Others>
void add_dashpot_forces(const BodyState& state, double dt, const HalfVelocity& half_velocity, const Others& others,
                        External&& external) {
  for (const auto& d : state.dashpots) {
    const double load = state.external.zero() ? 0.0 : external[d.dof];  // without loads f is what it was a step ago
    external[d.dof] = load + d.force_after_step(half_velocity(d.dof), others(d.dof, load), state.mass[d.dof], dt);
  }
}

/// The reactions at t_{n+1} join `external`.
inline void set_reactions(const BodyState& state, double time_s, double dt, const Eigen::VectorXd& internal,
                          Eigen::VectorXd& external) {
  for (const auto& c : state.constrained) {
    external[c.dof] = state.mass[c.dof] * c.acceleration(time_s, dt) + internal[c.dof];
  }
}

}  // namespace ricochet::solver
