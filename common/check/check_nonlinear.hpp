#pragma once

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Throws ConfigError, naming body and key, where elements that yield meet a method that rests on elastic ones: it
/// takes the answer of the start for all windows, or splits K.
void check_nonlinear(const Problem& problem);

}  // namespace ricochet::scene
