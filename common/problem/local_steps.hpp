#pragma once

#include "common/fem/local_steps.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Local steps of a whole body in windows of `window_s`, with its supports. `part`: all its elements.
[[nodiscard]] fem::LocalSteps local_steps(const BodyProblem& body, const fem::Part& part, double window_s);

}  // namespace ricochet::scene
