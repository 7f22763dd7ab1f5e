#include "coupler/command/run_scene.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "common/base/process.hpp"
#include "common/check/check.hpp"
#include "coupler/processes/machine_check.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/report/report.hpp"
#include "coupler/run/compute_scene.hpp"
#include "coupler/study/step_choice.hpp"

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
    fmt::print(stderr, "{}: no report.html: {}\n", command_name, error.what());
    return false;
  }
}

}  // namespace

void run_scene(const std::string& scene_path, const std::string& out) {
  auto problem = load_problem(scene_path);
  auto plan = scene::plan(problem);
  const auto executables = find_executables(problem.scene);
  const std::string stem = std::filesystem::path(problem.scene.path).stem().string();
  const ResultsDirectory results(out.empty() ? "out/" + stem : out, files_of_run(problem.scene), {problem.scene.path});
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
  fmt::print("{}{}\n", scene::to_text(problem, scene::plan(problem)), memory_text(problem.scene));
  if (const auto warning = address_warning(problem.scene); !warning.empty()) fmt::print("warning: {}\n", warning);
  if (problem.scene.time.largest_step_s) {
    fmt::print(
        "this is the largest step: `ricochet run` measures whether a smaller one, with less of it implicit, takes less "
        "time\n");
  }
}

}  // namespace ricochet::coupler
