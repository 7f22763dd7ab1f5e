#pragma once

#include <optional>
#include <string>

#include "common/check/check.hpp"
#include "common/cost/predicted_cost.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::coupler {

/// When a run of the scene would end [s]: if it goes on until the bodies are apart, and one-dimensional theory knows
/// when that is (impact_theory), then, else at time.end_s.
[[nodiscard]] double expected_end_s(const scene::Problem& problem);

/// Says how much of the disk the results of a run of this cost take, beside `free_bytes` of it, and, where these are
/// too few, which key makes results fewer. Without `free_bytes` nobody knows how many there are.
[[nodiscard]] std::string disk_text(const scene::Problem& problem, const cost::PredictedCost& cost,
                                    std::optional<double> free_bytes);

/// Memory and predicted time, as `ricochet check` prints them, with what the prediction does not know; memory alone
/// where a participant is somebody else's program, whose time nobody knows.
[[nodiscard]] std::string cost_text(const scene::Problem& problem, const scene::Plan& plan);

}  // namespace ricochet::coupler
