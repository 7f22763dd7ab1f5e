#pragma once

#include <string>
#include <vector>

#include "common/check/check.hpp"

namespace ricochet::coupler {

/// Lines of theory on the first impact of each contact at the initial velocities, a line each: force and duration by
/// impedances where surfaces are flat (impact_theory), by Hertz where they are round. Empty where neither applies.
///   Hertz: K = 4/3 E* sqrt(R), 1/E* = sum (1 - nu^2)/E, 1/m = sum 1/m_i, d = (5 m v^2/(4 K))^(2/5),
///   F = K d^(3/2), duration 2.9432 d/v; R from the gap r^2/(2R) beside the place where the bodies meet. A rigid
///   surface and a body that is held along the normal have no 1/m. Error: the curvature of the mesh, some percent.
///   Source: K. L. Johnson, Contact Mechanics (1985), 11.4.
[[nodiscard]] std::string impact_text(const scene::Problem& problem, const scene::Plan& plan);

/// By these theories how long the bodies of each contact touch; infinite where neither applies or loads may press them
/// together.
[[nodiscard]] std::vector<double> contact_durations_s(const scene::Problem& problem, const scene::Plan& plan);

/// Where the stress of these theories at the initial velocities is above material.yield_stress_pa or strength_pa, a
/// warning each: with flat surfaces the axial stress v / sum 1/(rho c) of free flanks, and as much tension from a free
/// end; of round ones first yield at p_max = 1.6 times the yield stress, and the tension (1 - 2 nu)/3 p_max at the rim.
/// And where the facets of a curved surface stand off it by more than a tenth of what the bodies approach in the impact
/// (d above; without it v/pi times the time of waves to and fro).
[[nodiscard]] std::vector<std::string> limit_warnings(const scene::Problem& problem, const scene::Plan& plan);

}  // namespace ricochet::coupler
