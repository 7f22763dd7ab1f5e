#pragma once

#include <Eigen/Core>

/// The one predictor/corrector of both solvers: Newmark's method with gamma = 1/2.
///   u_{n+1} = u_n + dt v_n + dt^2 (1/2 - beta) a_n + dt^2 beta a_{n+1}
///   v_{n+1} = v_n + dt/2 (a_n + a_{n+1})
/// beta = 0 is the central difference method (the predictor is already the displacement), beta = 1/4 the trapezoidal
/// rule. Source: section 4 of the paper (docs/words.md says which); Hughes and Liu 1978. Vectors per degree of freedom,
/// SI units.
namespace ricochet::fem {

inline constexpr double beta_explicit = 0.0;
inline constexpr double beta_implicit = 0.25;

/// u_n + dt v_n + dt^2 (1/2 - beta) a_n, as an expression that allocates nothing.
template <class U, class V, class A>
auto predicted_displacement(const U& u, const V& v, const A& a, double dt, double beta) {
  return u + dt * v + (dt * dt * (0.5 - beta)) * a;
}

/// The displacement that this adds to u_n.
template <class V, class A>
auto predicted_increment(const V& v, const A& a, double dt, double beta) {
  return dt * v + (dt * dt * (0.5 - beta)) * a;
}

/// v_n + dt/2 (a_n + a_{n+1}), as an expression.
template <class V, class A, class B>
auto corrected_velocity(const V& v, const A& a, const B& a_new, double dt) {
  return v + (0.5 * dt) * (a + a_new);
}

}  // namespace ricochet::fem
