#include "coupler/command/run_scene.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <thread>
#include <utility>

#include "common/base/archive.hpp"
#include "common/base/computer.hpp"
#include "common/base/error.hpp"
#include "common/base/own_files.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"
#include "common/check/check.hpp"
#include "coupler/command/advise.hpp"
#include "coupler/command/announcer.hpp"
#include "coupler/command/cost_text.hpp"
#include "coupler/command/impact_text.hpp"
#include "coupler/command/method_choice.hpp"
#include "coupler/processes/executable.hpp"
#include "coupler/processes/given_scene.hpp"
#include "coupler/processes/machine_check.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/report/report.hpp"
#include "coupler/report/scene_page/scene_page.hpp"
#include "coupler/results/checkpoint.hpp"
#include "coupler/run/checkpoints.hpp"
#include "coupler/run/compute_scene.hpp"
#include "coupler/study/companions.hpp"
#include "coupler/study/error_estimate.hpp"
#include "coupler/study/step_choice.hpp"

namespace ricochet::coupler {
namespace {

void print_warnings(const scene::Plan& plan) {
  for (const auto& warning : plan.warnings) fmt::print(stderr, "warning: {}\n", printable(warning));
}

/// False if the page could not be written, which changes nothing about the run.
bool try_report(const std::string& results) {
  try {
    report::write_report(results);
    return true;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: no report.html: {}\n", command_name, printable(error.what()));
    return false;
  }
}

}  // namespace

namespace {

/// A run that is accepted, to its last word.
void run_accepted(scene::Problem& problem, scene::Plan plan, const std::vector<std::string>& executables,
                  const ResultsDirectory& results, std::optional<Checkpoint> from) {
  const std::string stem = std::filesystem::path(problem.scene.path).stem().string();
  if (const auto warning = address_warning(problem.scene); !warning.empty()) plan.warnings.push_back(warning);
  for (auto& warning : limit_warnings(problem, plan)) plan.warnings.push_back(std::move(warning));
  print_warnings(plan);
  std::string table;
  try {
    table = compute_scene(problem, plan, executables, results, std::move(from));
  } catch (const std::exception& error) {
    try_report(results.path());
    fmt::print(stderr, "results so far: {}\n", printable(results.path()));
    const CheckpointFolder folder(results.file("checkpoint"));
    if (const auto windows = folder.windows(); !windows.empty())
      fmt::print(stderr, "to go on from window {}: {} resume {}\n", windows.back(), command_name,
                 printable(results.path()));
    throw;
  }
  const bool reported = try_report(results.path());
  const std::string waves = problem.scene.output.axial_stress_every > 0 ? ", axial_stress.csv" : "";
  const std::string probes = problem.scene.output.wants_probes() ? ", probes.csv" : "";
  const std::string fields = problem.scene.output.fields_every > 0 ? ", fields/" + stem + ".pvd (ParaView)" : "";
  fmt::print("{}", printable(fmt::format(
                       "{}results in {}: history.csv{}, summary.json, trace.json (ui.perfetto.dev), logs/{}{}\n", table,
                       results.path(), waves + probes, fields, reported ? ", report.html" : "")));
}

std::string checkpoints_of(const std::string& results) {
  return std::filesystem::absolute(results).lexically_normal().string() + "/checkpoint";
}

/// The last checkpoint of a folder of results that is whole; says which are not.
Checkpoint last_checkpoint(const std::string& results) {
  const CheckpointFolder folder(checkpoints_of(results));
  std::vector<std::string> damaged;
  auto found = folder.last(damaged);
  if (found) {
    for (const auto& text : damaged) fmt::print(stderr, "warning: {}\n", printable(text));
    return *std::move(found);
  }
  throw ConfigError(
      damaged.empty()
          ? fmt::format(
                "{} has no checkpoint; `{} run` makes one every checkpoint.every_s seconds, at SIGTERM and when "
                "`{} checkpoint` asks",
                results, command_name, command_name)
          : fmt::format("{} has no checkpoint that is whole: {}", results, fmt::join(damaged, "; ")));
}

/// The scene must be the one that the checkpoint is of, but for its end.
scene::Problem problem_of(const Checkpoint& from, const std::string& scene_path, std::optional<double> until_s,
                          std::optional<double> step_s) {
  const auto& path = scene_path.empty() ? from.scene_path : scene_path;
  std::error_code no_status;  // of a name that no file can have
  if (scene_path.empty() && !std::filesystem::is_regular_file(path, no_status))
    throw ConfigError(fmt::format("{}, the scene that the checkpoint names, is no file; --scene SCENE names it", path));
  auto problem = load_problem(path);
  auto& scene = problem.scene;
  if (scene.sha256 != from.scene_sha256) {
    throw ConfigError(
        fmt::format("{}: the scene or a mesh of it has changed since the checkpoint (SHA-256 {:.12} then, {:.12} now); "
                    "only the end and the step may: --until SECONDS, --step SECONDS",
                    scene.path, from.scene_sha256, scene.sha256));
  }
  if (until_s) scene.time.end_s = *until_s;
  read_clock(from, problem.clock);  // another step than the scene's may be an earlier resume's
  if (step_s && scene.time.flight_step_s)
    throw ConfigError(fmt::format("--step: found {}, with {}; allowed: the steps of the scene", *step_s,
                                  scene.where("time.flight_step_s")));
  if (step_s) problem.clock.change(from.window, *step_s);
  return problem;
}

/// "explicit: /usr/bin/mpirun -n 2 /opt/explicit_solver, implicit: ...", as they would be started.
std::string programs_text(const scene::Scene& scene, const std::vector<std::string>& executables) {
  std::string text;
  for (std::size_t p = 0; p < executables.size(); ++p) {
    const auto& participant = scene.participants[p];
    const bool launched = !executables[p].empty();
    auto words = launched ? launch_prefix(scene, participant) : std::vector<std::string>();
    words.push_back(launched ? executables[p] : "started by hand");
    text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", participant.name, fmt::join(words, " "));
  }
  return text;
}

}  // namespace

namespace {

struct Planned {
  scene::Problem problem;
  scene::Plan plan;
};

/// Says meanwhile what takes long of it.
/// `to_run`: of a scene whose errors choose the protocol no plan is made, since the default one may not bear its step.
Planned plan_scene(const GivenScene& given, Announcer& announcer, bool to_run = false) {
  announcer.begin("reading the scene and its meshes, pairing the contact");
  auto problem = given.load();
  if (to_run && !problem.scene.accuracy.empty() && !problem.scene.protocol_given()) return {std::move(problem), {}};
  announcer.begin("finding critical steps, and what can be refused");
  auto plan = scene::plan(problem);
  return {std::move(problem), std::move(plan)};
}

/// Beside what a run has left in the folder.
std::string write_scene_page(const std::string& scene_path, const std::string& picture_folder,
                             const std::string& page) {
  namespace fs = std::filesystem;
  const std::string stem = fs::path(scene_path).stem().string(), name = "scene.html";
  const auto folder = fs::absolute(picture_folder.empty() ? "out/" + stem + "_scene" : picture_folder);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw_errno(error.value(), "cannot create the folder " + folder.string());
  OwnFiles own(folder.string());
  own.keep({scene_path});
  own.claim({name});
  write_atomically((folder / name).string(), page);
  return (folder / name).string();
}

void add_error_bars(const scene::Problem& problem, const ResultsDirectory& results,
                    const std::map<std::string, double>& expected = {}) {
  std::fflush(stdout);
  fmt::print("{}", printable(estimate_error(problem.scene, problem.clock.size_s(1), results, expected)));
  try_report(results.path());
}

}  // namespace

void run_scene(const GivenScene& given, const std::string& out, bool with_error_bars) {
  auto [problem, plan] = [&] {
    Announcer announcer;
    return plan_scene(given, announcer, true);
  }();
  if (with_error_bars) require_companions(problem.scene, "--estimate-error");
  if (!problem.scene.accuracy.empty()) require_choice(problem, problem.scene.accuracy, "accuracy");
  auto executables = find_executables(problem.scene);
  const std::string stem = std::filesystem::path(given.path).stem().string();
  auto files = files_of_run(problem.scene);
  if (!given.set.empty()) files.push_back(changed_scene_name(given.path));
  const ResultsDirectory results(out.empty() ? "out/" + stem : out, files, {given.path});
  if (!given.set.empty()) {
    problem = load_problem(write_changed_scene(given.path, given.changes(), results.path()));
  }
  std::map<std::string, double> expected;
  if (problem.scene.leaves_open()) {
    if (problem.scene.accuracy.empty()) {
      problem = load_problem(choose_step(problem, results));
    } else {
      auto chosen = choose_by_accuracy(problem, results);
      problem = load_problem(chosen.scene);
      expected = std::move(chosen.expected);
    }
    plan = scene::plan(problem);
    executables = find_executables(problem.scene);  // another protocol may have other participants
  }
  run_accepted(problem, std::move(plan), executables, results, {});
  if (with_error_bars || !problem.scene.accuracy.empty()) add_error_bars(problem, results, expected);
}

void resume_run(const std::string& folder, const std::string& scene_path, std::optional<double> until_s,
                std::optional<double> step_s) {
  if (step_s && !(*step_s > 0.0))
    throw ConfigError(fmt::format("--step: found {}, allowed: a number of seconds > 0", *step_s));
  auto from = last_checkpoint(folder);
  auto problem = problem_of(from, scene_path, until_s, step_s);
  const auto executables = find_executables(problem.scene);
  const auto programs = programs_text(problem.scene, executables);
  if (scene_path.empty() && !from.by_this_user) {
    throw ConfigError(fmt::format(
        "the checkpoint in {0} names the scene {1}, which starts {2}; nothing shows that you began that run: read the "
        "scene, then type {3} resume {0} --scene {1}",
        folder, problem.scene.path, programs, command_name));
  }
  const auto plan = scene::plan(problem);
  if (plan.windows < from.window) {
    throw ConfigError(
        fmt::format("--until: found {} s, which is window {}; allowed: from window {} on, that of the checkpoint",
                    problem.scene.time.end_s, plan.windows, from.window));
  }
  const ResultsDirectory results(folder, files_of_run(problem.scene), {problem.scene.path}, Former::kept);
  results.go_on_from(from.window, participant_names(problem.scene));
  fmt::print(stderr, "going on from window {} (t = {:.6g} s) with the scene {}; {}\n", from.window, from.time_s,
             printable(problem.scene.path), printable(programs));
  if (const Computer here = this_computer(); from.computer != here)
    fmt::print(stderr,
               "note: the run began with processor \"{}\" and BLAS \"{}\", here they are \"{}\" and \"{}\": last bits "
               "may differ from those of a run without a break\n",
               printable(from.computer.processor), printable(from.computer.blas), printable(here.processor),
               printable(here.blas));
  run_accepted(problem, plan, executables, results, std::move(from));
  // Those of other ends and steps would be of the scene file, which has neither.
  if (!problem.scene.accuracy.empty() && !until_s && !step_s) add_error_bars(problem, results);
}

void request_checkpoint(const std::string& folder) {
  const CheckpointFolder checkpoints(checkpoints_of(folder));
  const auto holder = lock_holder(folder);
  if (!holder) throw ConfigError(fmt::format("no run is writing into {}", folder));
  if (!holder->a_run) throw ConfigError(fmt::format("no run is writing into {}: {}", folder, holder->text));
  const auto before = checkpoints.windows();
  const std::string request = checkpoints.path() + "/" + Checkpoints::request_name;
  std::error_code ignored;
  std::filesystem::create_directories(checkpoints.path(), ignored);
  write_atomically(request, "");
  while (std::filesystem::exists(request, ignored) && lock_holder(folder))
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const auto after = checkpoints.windows();
  if (after.empty() || (!before.empty() && after.back() == before.back()))
    throw ConfigError(fmt::format("the run in {} has made no checkpoint; what it printed says why", folder));
  fmt::print("checkpoint at window {}: {} resume {} goes on from there\n", after.back(), command_name, folder);
}

void check_scene(const GivenScene& given, const std::optional<std::string>& picture_folder) {
  Announcer announcer;
  const auto [problem, plan] = plan_scene(given, announcer);
  if (!problem.scene.accuracy.empty()) require_choice(problem, problem.scene.accuracy, "accuracy");
  std::string said;
  const auto say = [&said](const std::string& text) {
    fmt::print("{}", text);
    std::fflush(stdout);
    said += text;
  };
  say(printable(scene::to_text(problem, plan)) + printable(impact_text(problem, plan)));
  for (const auto& warning : limit_warnings(problem, plan)) say(fmt::format("warning: {}\n", printable(warning)));
  announcer.begin("predicting what a run costs: factors, fronts of waves");
  say(cost_text(problem, plan));
  if (const auto warning = address_warning(problem.scene); !warning.empty())
    say(fmt::format("warning: {}\n", printable(warning)));
  if (!problem.scene.accuracy.empty()) {
    say(fmt::format("asked: {}; `ricochet run` {}\n", to_text(problem.scene.accuracy),
                    problem.scene.leaves_open() ? "chooses what the scene leaves open of protocol, step and mesh, as "
                                                  "`ricochet advise` would, and says what was reached"
                                                : "says whether that was reached"));
  } else if (problem.scene.time.largest_step_s) {
    say("this is the largest step: `ricochet run` measures whether a smaller one, with less of it implicit, takes less "
        "time\n");
  }
  if (!picture_folder) return;
  announcer.begin("drawing the scene");
  const auto page = report::scene_page(problem, said);
  const auto path = write_scene_page(given.path, *picture_folder, page);
  fmt::print("wrote {}\n", path);
}

}  // namespace ricochet::coupler
