#pragma once

#include <string>

#include "common/check/check.hpp"

namespace ricochet::coupler {

/// What theory says of the first impact of each contact at the initial velocities, a line each: force and duration by
/// impedances where surfaces are flat (impact_theory), by Hertz where they are round. Empty where neither applies.
///   Hertz: K = 4/3 E* sqrt(R), 1/E* = sum (1 - nu^2)/E, 1/m = sum 1/m_i, d = (5 m v^2/(4 K))^(2/5),
///   F = K d^(3/2), duration 2.9432 d/v; R from the gap r^2/(2R) beside the place where the bodies meet. A rigid
///   surface and a body that is held along the normal have no 1/m. Error: the curvature of the mesh, some percent.
///   Source: K. L. Johnson, Contact Mechanics (1985), 11.4.
[[nodiscard]] std::string impact_text(const scene::Problem& problem, const scene::Plan& plan);

}  // namespace ricochet::coupler
