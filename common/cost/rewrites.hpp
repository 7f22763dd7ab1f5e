#pragma once

#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::cost {

/// Per contact, how often its rows are written anew in a run that ends at `end_s`, at the initial velocities and with
/// gravity along it. `contact_s`: how long the bodies touch; without it until the end.
[[nodiscard]] std::vector<double> rewrites(const scene::Problem& problem, double end_s,
                                           const std::vector<double>& contact_s);

}  // namespace ricochet::cost
