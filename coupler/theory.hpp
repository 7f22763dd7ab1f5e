#pragma once

#include <optional>
#include <string>

#include "common/scene/problem.hpp"

namespace ricochet::coupler {

/// One-dimensional impedance theory of the impact of two bodies, as a yardstick for a run.
///   c = sqrt(E/rho); plane strain sqrt(E/(rho(1-nu^2))), on a periodic mesh (no lateral strain) Eq. 26;
///   sigma = rho_1 c_1 rho_2 c_2/(rho_1 c_1 + rho_2 c_2) v,  v closing velocity before impact;
///   separation 2L/c after the first contact, of the body in which the wave is back first.
/// Exact for bars; for an axisymmetric cylinder the mean over the surface, without lateral inertia.
struct ImpactTheory {
  double contact_duration_s = 0.0;  ///< 2L/c
  std::string body;                 ///< whose 2L/c it is
  double stress_pa = 0.0;
};

/// Empty without contact, with a rigid plane, or if the bodies do not approach each other.
[[nodiscard]] std::optional<ImpactTheory> impact_theory(const scene::Problem& problem);

}  // namespace ricochet::coupler
