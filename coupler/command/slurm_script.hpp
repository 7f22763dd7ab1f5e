#pragma once

#include <optional>
#include <string>

namespace ricochet::coupler {

/// `ricochet slurm-script`: writes the batch script that computes a scene, to the file `out`, or to standard output if
/// that is empty. `time`: the job's limit, as Slurm writes times; none: the partition's. Throws ConfigError if the
/// scene is wrong, the file exists, or Slurm knows no such time.
void write_slurm_script(const std::string& scene_path, const std::string& out, const std::optional<std::string>& time);

}  // namespace ricochet::coupler
