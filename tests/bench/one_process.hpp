#pragma once

#include <string>

namespace ricochet::bench {

/// Computes a scene with both solvers in this process: the same protocol, time loop, links and sessions as three
/// processes, but messages are passed as objects. `all_rows`: the explicit solver computes those that no wave has reached, too.
/// Returns the stepping time per window [s].
double run_in_one_process(const std::string& scene_path, bool all_rows = false);

}  // namespace ricochet::bench
