#pragma once

#include <string>

#include "common/problem/problem.hpp"

namespace ricochet::report {

/// A page that draws a scene before it runs: its bodies coloured by who integrates them, and the nodes of contact
/// surfaces, interface, supports, loads, joints, probes. `checked`: what `ricochet check` says of it, shown below.
/// Throws ConfigError if the bodies have more cells than SeenCells::most.
[[nodiscard]] std::string scene_page(const scene::Problem& problem, const std::string& checked);

}  // namespace ricochet::report
