#pragma once

#include <string>

#include "common/scene/scene.hpp"
#include "coupler/results/results_directory.hpp"

namespace ricochet::coupler {

/// `ricochet run --estimate-error`, once the run is done: computes its companions, which stay in the folder accuracy/
/// of the results, adds `error_bar` to summary.json (docs/accuracy.md) and returns the lines for the console. A
/// companion that fails leaves its part unknown, with the reason. For each quantity of the scene's table [accuracy] a
/// line says whether its error is reached.
[[nodiscard]] std::string estimate_error(const scene::Scene& scene, double step_s, const ResultsDirectory& results);

}  // namespace ricochet::coupler
