#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.hpp"

namespace ricochet::coupler {

/// Name of the program for such a participant which this command brings along.
[[nodiscard]] std::string shipped_program(const scene::ParticipantSpec& participant);

/// Path of the program of a participant: the scene's `executable` (relative to the folder of the scene file; a name
/// without a slash is looked up in PATH), or the solver shipped beside this program.
/// Throws ParticipantError naming the path and what to do if it is missing or may not be executed.
[[nodiscard]] std::string find_executable(const scene::Scene& scene, const scene::ParticipantSpec& participant);

/// The words that stand in front of that program: the scene's `launch`, under Slurm those of a step, of a participant
/// with ranks those that start so many processes; none otherwise.
/// Throws ParticipantError if the first is no program, ConfigError under Slurm outside an allocation.
[[nodiscard]] std::vector<std::string> launch_prefix(const scene::Scene& scene,
                                                     const scene::ParticipantSpec& participant);

}  // namespace ricochet::coupler
