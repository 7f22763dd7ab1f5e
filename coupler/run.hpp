#pragma once

#include <exception>
#include <string>
#include <vector>

#include "common/scene/check.hpp"
#include "coupler/results_directory.hpp"

namespace ricochet::coupler {

/// `ricochet run`: checks the scene, starts its participants, couples them to the end, writes the results into `out`
/// (empty: "out/<name of the scene file>") and prints the table. Whatever happens, no participant outlives this call
/// and history.csv and summary.json are there once the scene has been accepted. Throws ricochet::Error (its exit code
/// says what kind) or Interrupted.
void run_scene(const std::string& scene_path, const std::string& out);

/// What `run_scene` does once the scene is accepted, without report.html and without a word but the progress: one run
/// into `results`. Returns the table of its end.
std::string compute_scene(const scene::Problem& problem, const scene::Plan& plan,
                          const std::vector<std::string>& executables, const ResultsDirectory& results);

/// What a run of the scene may write into its results folder, for ResultsDirectory.
[[nodiscard]] std::vector<std::string> files_of_run(const scene::Scene& scene);

/// Status of a run that an error ended, as in summary.json: "interrupted" | "scene_wrong" | "unstable" |
/// "participant_failed" | "protocol_broken" | "machine_failed".
[[nodiscard]] std::string status_of(const std::exception& error);

/// Exit code of an error that ended a command: see base/error.hpp; 128 + signal if interrupted, 1 for anything else.
[[nodiscard]] int exit_code_of(const std::exception& error);

/// `ricochet check`: prints what the run would be, without starting a process. Throws ConfigError.
void check_scene(const std::string& scene_path);

}  // namespace ricochet::coupler
