#pragma once

#include <vector>

#include "common/body/body_state.hpp"

/// The motion of a participant as one row of numbers: per part u, then v, of the degrees of freedom that it integrates
/// and that no support holds. For `ricochet stability`.
namespace ricochet::solver {

/// Takes the motion and makes the parts homogeneous: no loads, supports and prescribed motion at zero, u measured from
/// equilibrium. `row` has as many numbers as `read_motion` appends.
void load_motion(const std::vector<double>& row, std::vector<BodyState>& states);

/// The part of a motion that `load_motion` takes away.
struct Surroundings {
  scene::ExternalForce external;
  std::vector<ConstrainedDof> constrained;
  std::vector<Dashpot> dashpots;
};
[[nodiscard]] std::vector<Surroundings> surroundings_of(const std::vector<BodyState>& states);
void give_back(const std::vector<Surroundings>& surroundings, std::vector<BodyState>& states);

/// Appends the motion, and per number the scale that makes it the root of an energy: sqrt(m)/dt for u, sqrt(m) for v.
void read_motion(const std::vector<BodyState>& states, double dt, std::vector<double>& row, std::vector<double>& scale);

}  // namespace ricochet::solver
