#pragma once

#include <cmath>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// The motion of a held degree of freedom,
///   u(t) = displacement f(t) + across sin(angle g(t)) + inward (1 - cos(angle g(t))):
/// along itself, f being 1 if nothing is prescribed, and by a turn by angle g(t) about the unit vector n (Rodrigues'
/// formula): across is a component of n x r and inward of n x (n x r), r = X - about.
struct GivenMotion {
  double displacement_m = 0.0;
  const Amplitude* along = nullptr;  ///< f; null: the displacement stays
  double across_m = 0.0, inward_m = 0.0, angle_rad = 0.0;
  const Amplitude* turn = nullptr;  ///< g; null: no turn

  /// Whether it is more than a place.
  [[nodiscard]] bool moves() const { return along != nullptr || turn != nullptr; }
  [[nodiscard]] double at(double time_s) const {
    double u = along != nullptr ? displacement_m * along->at(time_s) : displacement_m;
    if (turn != nullptr) {
      const double angle = angle_rad * turn->at(time_s), half = std::sin(0.5 * angle);
      u += across_m * std::sin(angle) + inward_m * (2.0 * half * half);
    }
    return u;
  }
};

/// The motion [m] of a degree of freedom that is held but not still. Its amplitudes are those of `spec`, which must
/// outlive it.
[[nodiscard]] GivenMotion given_motion(const Body& spec, const BodyProblem& body, int dof);

}  // namespace ricochet::scene
