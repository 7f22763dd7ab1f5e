#pragma once

#include <optional>
#include <string>

#include "common/problem/problem.hpp"

namespace ricochet::coupler {

/// One-dimensional impedance theory of the impact of two bodies, as a yardstick for a run.
///   c = sqrt(E/rho); plane strain sqrt(E/(rho(1-nu^2))), on a periodic mesh (no lateral strain) Eq. 26;
///   Z = rho c A (A = 1 but for bars),  contact stress = Z_1 Z_2/(Z_1 + Z_2) v / A,  v closing velocity before impact;
///   separation 2L/c after the first contact, of the body of lower impedance: the wave that returns in the other one
///   first leaves the contact under pressure. For equal impedances the shorter time counts.
/// Exact for bars; for an axisymmetric cylinder the mean over the surface, without lateral inertia.
struct ImpactTheory {
  double contact_duration_s = 0.0;  ///< 2L/c
  std::string body;                 ///< whose 2L/c it is
  double stress_pa = 0.0;
  double closing_velocity_m_s = 0.0;
  bool other_body_returns_later = false;  ///< else a wave of the other body changes the stress before the end
  double first_step_s = 0.0;  ///< so long the stress is `stress_pa`: until the first wave is back, of either body
};

/// Empty without contact, with a rigid plane or body, if the bodies do not approach each other, if the body whose wave
/// would end the contact absorbs it, and where a body is no free one at rest in itself: supports or prescribed motion
/// along the normal, loads, initial deformation, a nose or surfaces that are not parallel.
[[nodiscard]] std::optional<ImpactTheory> impact_theory(const scene::Problem& problem);

/// rho c per area of a body, of a bar rho c A: c of a long wave along it, sqrt(E/rho) with free flanks, in plane strain
/// sqrt(E/(rho (1 - nu^2))), of a body that repeats across the dilatational one [kg/(m^2 s), kg/s].
[[nodiscard]] double axial_impedance(const scene::Problem& problem, std::size_t body);
/// Von Mises stress over the axial stress of that wave.
[[nodiscard]] double von_mises_share(const scene::Problem& problem, std::size_t body);

}  // namespace ricochet::coupler
