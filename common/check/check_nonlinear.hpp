#pragma once

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Throws ConfigError, naming body and key, where elements that yield or turn meet a method that rests on linear
/// ones: it takes the answer of the start for all windows, or splits K; and where what is around a body that turns
/// keeps its directions.
void check_nonlinear(const Problem& problem);

}  // namespace ricochet::scene
