#pragma once

#include "common/fem/local_steps.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Local steps of a whole body in windows of `window_s`, with its supports. `part`: all its elements.
[[nodiscard]] fem::LocalSteps local_steps(const BodyProblem& body, const fem::Part& part, double window_s,
                                          fem::LocalSteps::Levels levels = fem::LocalSteps::Levels::borne);

/// Of a participant's part in such windows, by BodyProblem::small_steps; none where that is empty.
/// `shared`: its nodes that the link moves, with the mass that all their elements have.
[[nodiscard]] fem::LocalSteps local_steps(const Problem& problem, int body, const fem::Part& part,
                                          const std::vector<int>& shared, double window_s);

/// Rows of K that a window multiplies beside the whole, over all rows: once for the body's own forces, and once more
/// for contact forces that act inside the small steps.
[[nodiscard]] double extra_rows(const Problem& problem, int body, const fem::LocalSteps& steps);

/// Whether the scene could run under `local_explicit` with its own step.
[[nodiscard]] bool takes_local_steps(const Problem& problem);

}  // namespace ricochet::scene
