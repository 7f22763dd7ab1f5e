#pragma once

#include <string>
#include <vector>

#include "common/check/check.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// The local steps that a part takes. Throws ConfigError where none bear the window, and where an absorbing surface
/// lies among nodes that step locally, whose dashpots know no small steps.
[[nodiscard]] LocalStepsPlan plan_local_steps(const Problem& problem, const ParticipantPart& part);
/// The lines of `check` on them. Throws ConfigError where the step is too long for every element.
void check_local_steps(const Problem& problem, Plan& plan);

}  // namespace ricochet::scene
