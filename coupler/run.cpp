#include "coupler/run.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <optional>

#include "common/base/error.hpp"
#include "coupler/coupled_run.hpp"
#include "coupler/interrupted.hpp"
#include "coupler/machine_check.hpp"
#include "coupler/participants.hpp"
#include "coupler/report/report.hpp"
#include "coupler/step_choice.hpp"

namespace ricochet::coupler {
namespace {

void print_warnings(const scene::Plan& plan) {
  for (const auto& warning : plan.warnings) fmt::print(stderr, "warning: {}\n", warning);
}

/// False if the page could not be written, which changes nothing about the run.
bool try_report(const std::string& results) {
  try {
    report::write_report(results);
    return true;
  } catch (const std::exception& error) {
    fmt::print(stderr, "ricochet: no report.html: {}\n", error.what());
    return false;
  }
}

}  // namespace

int exit_code_of(const std::exception& error) {
  if (const auto* interrupted = dynamic_cast<const Interrupted*>(&error)) return interrupted->exit_code();
  return exit_code_of_exception(error);
}

std::string status_of(const std::exception& error) {
  if (dynamic_cast<const Interrupted*>(&error)) return "interrupted";
  switch (static_cast<ExitCode>(exit_code_of_exception(error))) {
    case ExitCode::config:
      return "scene_wrong";
    case ExitCode::unstable:
      return "unstable";
    case ExitCode::protocol:
      return "protocol_broken";
    case ExitCode::model:
      return "left_model";
    case ExitCode::machine:
      return "machine_failed";
    default:
      return "participant_failed";
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
    names.push_back("fields/" + participant.name + ".axial_stress");
  }
  if (scene.time.largest_step_s) names.insert(names.end(), {"calibration.csv", "scene.toml"});
  return names;
}

std::string compute_scene(const scene::Problem& problem, const scene::Plan& plan,
                          const std::vector<std::string>& executables, const ResultsDirectory& results) {
  CoupledRun run(problem, plan, results);
  try {
    run.run(executables);
  } catch (const std::exception& error) {
    run.fail(status_of(error), exit_code_of(error), text_of(error));
    throw;
  }
  return run.table();
}

void run_scene(const std::string& scene_path, const std::string& out) {
  auto problem = load_problem(scene_path);
  auto plan = scene::plan(problem);
  const auto executables = find_executables(problem.scene);
  const std::string stem = std::filesystem::path(problem.scene.path).stem().string();
  const ResultsDirectory results(out.empty() ? "out/" + stem : out, files_of_run(problem.scene));
  if (problem.scene.time.largest_step_s) {
    problem = load_problem(choose_step(problem, results));
    plan = scene::plan(problem);
  }
  if (const auto warning = address_warning(problem.scene); !warning.empty()) plan.warnings.push_back(warning);
  print_warnings(plan);
  std::string table;
  try {
    table = compute_scene(problem, plan, executables, results);
  } catch (const std::exception& error) {
    try_report(results.path());
    fmt::print(stderr, "results so far: {}\n", results.path());
    throw;
  }
  const bool reported = try_report(results.path());
  const std::string waves = problem.scene.output.axial_stress_every > 0 ? ", axial_stress.csv" : "";
  const std::string fields = problem.scene.output.fields_every > 0 ? ", fields/" + stem + ".pvd (ParaView)" : "";
  fmt::print("{}results in {}: history.csv{}, summary.json, trace.json (ui.perfetto.dev), logs/{}{}\n", table,
             results.path(), waves, fields, reported ? ", report.html" : "");
}

void check_scene(const std::string& scene_path) {
  const auto problem = load_problem(scene_path);
  fmt::print("{}{}\n", scene::to_text(scene::plan(problem)), memory_text(problem.scene));
  if (const auto warning = address_warning(problem.scene); !warning.empty()) fmt::print("warning: {}\n", warning);
  if (problem.scene.time.largest_step_s) {
    fmt::print("this is the largest step: `ricochet run` measures whether a smaller one, with less of it implicit, takes less "
               "time\n");
  }
}

}  // namespace ricochet::coupler
