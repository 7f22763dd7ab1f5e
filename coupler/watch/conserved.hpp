#pragma once

#include "common/problem/problem.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// Conserved by a scene. In axisymmetry that is the axial momentum alone: the sum over the ring of the radial one is
/// no momentum, whichever of normal and tangent is radial. Angular momentum is balanced in plane strain, if no mesh
/// repeats across.
[[nodiscard]] Conserved conserved_by(const scene::Problem& problem);

}  // namespace ricochet::coupler
