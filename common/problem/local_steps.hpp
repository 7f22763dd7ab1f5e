#pragma once

#include "common/fem/local_steps.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Local steps that a whole body would take in windows of `window_s`, with its supports: the first levels, untried, for
/// who asks what they would cost. `part`: all its elements.
[[nodiscard]] fem::LocalSteps expected_local_steps(const BodyProblem& body, const fem::Part& part, double window_s);

/// The local steps of a participant's part in windows of `window_s`, by BodyProblem::small_steps; none where that is
/// empty. `shared`: its nodes that the link moves, with the mass that all their elements have. Throws SolverError where
/// no small steps bear the window.
[[nodiscard]] fem::LocalSteps local_steps(const Problem& problem, int body, const fem::Part& part,
                                          const std::vector<int>& shared, double window_s);

/// Rows of K that a window multiplies beside the whole, over all rows: once for the body's own forces, and once more
/// for contact forces that act inside the small steps.
[[nodiscard]] double extra_rows(const Problem& problem, int body, const fem::LocalSteps& steps);

/// Whether the scene could run under `local_explicit` with its own step.
[[nodiscard]] bool takes_local_steps(const Problem& problem);

}  // namespace ricochet::scene
