#pragma once

#include "common/body/body_state.hpp"
#include "common/problem/local_steps.hpp"

namespace ricochet::solver {

/// Whether elements of its body may take several steps in a window.
[[nodiscard]] inline bool takes_small_steps(const scene::Problem& problem, const BodyState& state) {
  return !problem.bodies[fem::at(state.body)].small_steps.empty();
}

/// The steps that its part takes in windows of `window_s`. Throws SolverError where none bear the window.
[[nodiscard]] inline fem::LocalSteps local_steps(const scene::Problem& problem, const BodyState& state,
                                                 double window_s) {
  return scene::local_steps(problem, state.body, state.part, state.shared_nodes, window_s);
}

}  // namespace ricochet::solver
