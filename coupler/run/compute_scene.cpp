#include "coupler/run/compute_scene.hpp"

#include <filesystem>

#include "common/base/error.hpp"
#include "coupler/processes/interrupted.hpp"
#include "coupler/run/coupled_run.hpp"

namespace ricochet::coupler {

int exit_code_of(const std::exception& error) {
  if (const auto* interrupted = dynamic_cast<const Interrupted*>(&error)) return interrupted->exit_code();
  return exit_code_of_exception(error);
}

RunStatus status_of(const std::exception& error) {
  if (dynamic_cast<const Interrupted*>(&error)) return RunStatus::interrupted;
  switch (static_cast<ExitCode>(exit_code_of_exception(error))) {
    case ExitCode::config: return RunStatus::scene_wrong;
    case ExitCode::unstable: return RunStatus::unstable;
    case ExitCode::protocol: return RunStatus::protocol_broken;
    case ExitCode::model: return RunStatus::left_model;
    case ExitCode::machine: return RunStatus::machine_failed;
    default: return RunStatus::participant_failed;
  }
}

std::vector<std::string> files_of_run(const scene::Scene& scene) {
  const std::string stem = std::filesystem::path(scene.path).stem().string();
  std::vector<std::string> names = {"history.csv", "axial_stress.csv", "summary.json",
                                    "trace.json",  "report.html",      "fields/" + stem + ".pvd"};
  for (const auto& participant : scene.participants) {
    names.push_back("logs/" + participant.name + ".log");
    names.push_back("keys/" + participant.name + ".key");
    names.push_back("fields/" + participant.name + "_#.vtu");
    names.push_back("fields/" + participant.name + ".shapes.json");
  }
  if (scene.time.largest_step_s) names.insert(names.end(), {"calibration.csv", "scene.toml"});
  return names;
}

std::string compute_scene(const scene::Problem& problem, const scene::Plan& plan,
                          const std::vector<std::string>& executables, const ResultsDirectory& results) {
  CoupledRun run(problem, plan, executables, results);
  try {
    run.run();
  } catch (const std::exception& error) {
    run.fail(status_of(error), exit_code_of(error), text_of(error));
    throw;
  }
  return run.table();
}

}  // namespace ricochet::coupler
