#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "coupler/results/results_directory.hpp"

/// The step and, with `rule = "auto"`, the implicit part that take the least time (`time.largest_step_s`): found by
/// running the scene's own processes for some windows with each of a few candidates. Measured, not modelled: elements,
/// factor, contact, exchange and what of it runs at the same time are all in it.
namespace ricochet::coupler {

/// Steps worth trying, longest first: the largest allowed, and below it, by powers of two, the next at which other
/// elements become explicit, which is `safety_factor` times the critical step of some element; with the last one all of
/// them are. `element_steps_s`: of the elements that may become explicit, any order.
[[nodiscard]] std::vector<double> candidate_steps(std::vector<double> element_steps_s, double largest_s,
                                                  double safety_factor);

/// Measures the candidates, prints what it has found, and writes it to calibration.csv. Returns the scene file to run:
/// scene/NAME.toml in the results folder, the scene with the step chosen. Candidates that were measured before with the
/// same scene, meshes and programs are not run again. A candidate that fails is printed with its reason; if all fail,
/// it is the largest step that is returned, whose run then says why.
[[nodiscard]] std::string choose_step(const scene::Problem& problem, const ResultsDirectory& results);

}  // namespace ricochet::coupler
