#include "coupler/run/compute_scene.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "coupler/processes/given_scene.hpp"
#include "coupler/processes/interrupted.hpp"
#include "coupler/processes/participants.hpp"
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
  std::vector<std::string> names = {"history.csv",
                                    "axial_stress.csv",
                                    "probes.csv",
                                    "summary.json",
                                    "trace.json",
                                    "report.html",
                                    "fields/obstacles.json",
                                    "fields/" + stem + ".pvd",
                                    "fields/" + stem + "_#.vtm"};
  for (const auto& participant : scene.participants) {
    names.push_back("logs/" + participant.name + ".log");
    names.push_back("keys/" + participant.name + ".key");
    names.push_back("fields/" + participant.name + "_#.vtu");
    for (const auto& body : scene.bodies) names.push_back("fields/" + participant.name + "." + body.name + "_#.vtu");
    names.push_back("fields/" + participant.name + ".shapes.json");
  }
  const auto checkpoints = CheckpointFolder::names(participant_names(scene));
  names.insert(names.end(), checkpoints.begin(), checkpoints.end());
  if (scene.leaves_open())
    names.insert(names.end(),
                 {scene.accuracy.empty() ? "calibration.csv" : "advice.csv", changed_scene_name(scene.path)});
  return names;
}

namespace {

std::string compute_once(scene::Problem& problem, const scene::Plan& plan, const std::vector<std::string>& executables,
                         const ResultsDirectory& results, const Checkpoint* from) {
  CoupledRun run(problem, plan, executables, results, from);
  try {
    run.run();
  } catch (const std::exception& error) {
    run.fail(status_of(error), exit_code_of(error), text_of(error));
    throw;
  }
  return run.table();
}

}  // namespace

std::optional<Checkpoint> checkpoint_of(const std::string& results, const scene::Scene& scene) {
  std::vector<std::string> damaged;
  auto last = CheckpointFolder(results + "/checkpoint").last(damaged);
  for (const auto& text : damaged) fmt::print(stderr, "warning: {}\n", printable(text));
  if (last && (last->scene_sha256 != scene.sha256 || last->scene_path != scene.path)) last.reset();
  return last;
}

std::string compute_scene(scene::Problem& problem, const scene::Plan& plan, const std::vector<std::string>& executables,
                          const ResultsDirectory& results, std::optional<Checkpoint> from) {
  const auto& asked = problem.scene.checkpoint;
  for (int attempt = 1;; ++attempt) {
    try {
      return compute_once(problem, plan, executables, results, from ? &*from : nullptr);
    } catch (const ParticipantError& error) {
      if (asked.on_failure != scene::OnFailure::resume || attempt > asked.attempts) throw;
      if (auto last = checkpoint_of(results.path(), problem.scene)) from = std::move(last);
      results.go_on_from(from ? from->window : 0, participant_names(problem.scene));
      fmt::print(stderr, "warning: {}\nwarning: going on from window {} (attempt {} of {})\n", printable(error.what()),
                 from ? from->window : 0, attempt, asked.attempts);
    }
  }
}

}  // namespace ricochet::coupler
