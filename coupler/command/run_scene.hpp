#pragma once

#include <string>

namespace ricochet::coupler {

/// `ricochet run`: checks the scene, starts its participants, couples them to the end, writes the results into `out`
/// (empty: "out/<name of the scene file>") and prints the table. Whatever happens, no participant outlives this call
/// and history.csv and summary.json are there once the scene has been accepted. Throws ricochet::Error (its exit code
/// says what kind) or Interrupted.
void run_scene(const std::string& scene_path, const std::string& out);

/// `ricochet check`: prints what the run would be, without starting a process. Throws ConfigError.
void check_scene(const std::string& scene_path);

}  // namespace ricochet::coupler
