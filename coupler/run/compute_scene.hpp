#pragma once

#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "common/base/vocabulary.hpp"
#include "common/check/check.hpp"
#include "coupler/results/checkpoint.hpp"
#include "coupler/results/results_directory.hpp"

namespace ricochet::coupler {

/// The work of `run_scene` once the scene is accepted, without report.html and without a word but the progress: one run
/// into `results`, from the start or `from` a checkpoint on. With on_failure = "resume" it begins again from the last
/// checkpoint when a participant is lost. Returns the table of its end. The problem's clock becomes that of the windows
/// there were.
std::string compute_scene(scene::Problem& problem, const scene::Plan& plan, const std::vector<std::string>& executables,
                          const ResultsDirectory& results, std::optional<Checkpoint> from = {});

/// The last whole checkpoint in a folder of results, if it is of this very scene. Says on stderr which are damaged.
[[nodiscard]] std::optional<Checkpoint> checkpoint_of(const std::string& results, const scene::Scene& scene);

/// The files that a run of the scene may write into its results folder, for ResultsDirectory.
[[nodiscard]] std::vector<std::string> files_of_run(const scene::Scene& scene);

/// Status of a run that an error ended, as in summary.json.
[[nodiscard]] RunStatus status_of(const std::exception& error);

/// Exit code of an error that ended a command: see base/error.hpp; 128 + signal if interrupted, 1 for anything else.
[[nodiscard]] int exit_code_of(const std::exception& error);

}  // namespace ricochet::coupler
