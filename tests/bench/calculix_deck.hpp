#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::bench {

/// Input deck of CalculiX for the first `steps` windows of an axisymmetric scene of two bodies: the scene's own nodes,
/// elements, supports, densities and initial velocities, the trapezoidal rule (ALPHA = 0) at the scene's fixed step,
/// Coulomb friction.
///
/// Elements are linear wedges of 2 degrees, written out: CalculiX makes the same of CAX4, but leaves initial velocities
/// behind on the way (version 2.20) and the elements at the axis without contact. Nodes lie at z = 0 and, turned about
/// the axis, at 2 degrees; equations tie the second to the first.
///
/// Contact is CalculiX's surface-to-surface penalty, linear, of the stiffness E / h [Pa/m]: E of the softer body, h the
/// shortest edge of the first contact surface, so that contact is about as stiff as one element. Five times as stiff,
/// the pressure chatters between steps.
///
/// Throws ConfigError for another model, a rigid plane, a gap, loads, and elements that touch the axis with a single
/// node.
[[nodiscard]] std::string calculix_deck(const scene::Problem& problem, long steps);

/// History of the mean contact pressure, at the ends of steps.
struct PressureHistory {
  std::vector<double> time_s, pressure_pa;
};

/// From the results (.dat) that the deck asks for: normal force over area, compression positive.
[[nodiscard]] PressureHistory calculix_pressure(const std::string& results);

}  // namespace ricochet::bench
