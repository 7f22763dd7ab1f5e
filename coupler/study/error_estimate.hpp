#pragma once

#include <map>
#include <string>

#include "common/scene/scene.hpp"
#include "coupler/results/results_directory.hpp"

namespace ricochet::coupler {

/// `ricochet run --estimate-error`, once the run is done: computes its companions, which stay in the folder accuracy/
/// of the results, adds `error_bar` to summary.json (docs/accuracy.md) and returns the lines for the console. A
/// companion that fails leaves its part unknown, with the reason. For each quantity of the scene's table [accuracy] a
/// line says whether its error is reached, and, if it is not, what to ask for: `expected` are the relative errors by
/// which protocol, step or mesh were chosen, if they were.
[[nodiscard]] std::string estimate_error(const scene::Scene& scene, double step_s, const ResultsDirectory& results,
                                         const std::map<std::string, double>& expected);

}  // namespace ricochet::coupler
