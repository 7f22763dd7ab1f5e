#include "coupler/command/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "coupler/command/run_scene.hpp"
#include "coupler/command/starter_scene.hpp"
#include "coupler/contract/contract_check.hpp"
#include "coupler/report/pictures.hpp"
#include "coupler/report/report.hpp"
#include "coupler/run/compute_scene.hpp"
#include "coupler/stability/stability_study.hpp"
#include "coupler/study/study.hpp"

namespace ricochet::coupler {
namespace {

const char* const exit_codes =
    "Exit codes: 0 done, 2 the scene or the command line is wrong, 3 unstable, 4 a participant failed,\n"
    "            5 the coupling protocol was broken, 6 the run left the model,\n"
    "            7 the machine lacks something (memory, disk, files), 130 interrupted (Ctrl-C; 128 + signal).";

struct Arguments {
  std::string scene, study, out, name, results;
  ContractCommand command;
  std::optional<double> step_s;
  StabilityRequest stability;
};

void define(CLI::App& app, Arguments& arguments) {
  app.name("ricochet");
  app.description("Hybrid implicit-explicit analysis of dynamic contact by impact.");
  app.footer(exit_codes);
  app.set_version_flag("--version", std::string("ricochet ") + RICOCHET_VERSION);
  app.require_subcommand(0, 1);
  auto* run = app.add_subcommand("run", "Compute a scene: start its participants, couple them, write the results");
  run->add_option("SCENE", arguments.scene, "Scene file (TOML)")->required();
  run->add_option("--out", arguments.out, "Results folder; default: out/<name of the scene file>")->type_name("DIR");
  auto* check = app.add_subcommand("check", "Report and refuse all that can be known before a process starts");
  check->add_option("SCENE", arguments.scene, "Scene file (TOML)")->required();
  auto* stability = app.add_subcommand("stability", "Measure at which steps the coupled scheme is stable");
  stability->add_option("SCENE", arguments.stability.scene, "Scene file (TOML)")->required();
  stability
      ->add_option("--out", arguments.stability.out, "Results folder; default: out/<name of the scene file>_stability")
      ->type_name("DIR");
  stability
      ->add_option("--sweep", arguments.stability.sweep,
                   "Steps: courant (share of the critical step) or time.step_s =LOW:HIGH:COUNT[:log] or =VALUE,...")
      ->capture_default_str();
  stability->add_option("--against", arguments.stability.against,
                        "Other parameter: a key of the scene =LOW:HIGH:COUNT[:log] or =VALUE,VALUE,...");
  stability->add_flag("--edge", arguments.stability.edge, "Bisect the measured edge to 0.5 %");
  auto* study = app.add_subcommand("study", "Compute a scene by many methods and settings: error against time");
  study->add_option("STUDY", arguments.study, "Study file (TOML)")->required();
  study->add_option("--out", arguments.out, "Results folder; default: out/<name of the study file>")->type_name("DIR");
  auto* report =
      app.add_subcommand("report", "Write the charts once more: DIR/report.html, and each as a picture in DIR/charts");
  report->add_option("DIR", arguments.results, "Results folder of a run, a study or a stability map")->required();
  auto* contract =
      app.add_subcommand("check-participant", "Run a program through the contract of docs/participants.md");
  contract->add_option("COMMAND", arguments.command.words, "Program and arguments, after --; --connect is appended")
      ->required();
  contract->add_option("--step", arguments.step_s, "Window size [s]; default: half of its critical time step");
  contract->add_option("--timeout", arguments.command.timeout_s, "Longest wait for an answer [s]")
      ->capture_default_str();
  auto* init = app.add_subcommand("init", "Write a commented starter scene NAME.toml");
  init->add_option("NAME", arguments.name, "Name of the new scene")->required();
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// What CLI11 could not place: an unknown command, or an unknown option of the command that was given.
[[noreturn]] void refuse_extra(const CLI::App& app) {
  const auto given = app.get_subcommands();
  const CLI::App& command = given.empty() ? app : *given.front();
  auto extras = command.remaining();
  if (extras.empty()) extras = app.remaining();
  const std::string extra = extras.empty() ? "" : extras.front();
  if (given.empty() && extra.rfind('-', 0) != 0) {
    std::vector<std::string> commands;
    for (const auto* sub : app.get_subcommands(nullptr)) commands.push_back(sub->get_name());
    throw ConfigError(fmt::format("unknown command \"{}\", allowed are {}{}", extra, fmt::join(commands, ", "),
                                  did_you_mean(extra, commands)));
  }
  const auto known = option_names(command);
  throw ConfigError(fmt::format("unexpected argument \"{}\", allowed options are {}{}", extra, fmt::join(known, ", "),
                                did_you_mean(extra, known)));
}

/// The page, which a browser draws, and its charts as files.
void write_report(const std::string& folder) {
  const auto page = report::write_report(folder);
  fmt::print("wrote {}\n", page.path);
  const auto pictures = report::draw_pictures(page);
  if (pictures.obstacle.empty()) {
    fmt::print("wrote {} pictures (SVG) in {}\n", pictures.count, pictures.folder);
  } else {
    fmt::print("{}\n", pictures.obstacle);
  }
}

bool check_contract(const Arguments& arguments) {
  const auto require_positive = [](const char* option, double value) {
    if (!(value > 0.0)) throw ConfigError(fmt::format("{}: found {}, allowed: a number of seconds > 0", option, value));
  };
  require_positive("--timeout", arguments.command.timeout_s);
  if (arguments.step_s) require_positive("--step", *arguments.step_s);
  return check_participant(arguments.command, arguments.step_s.value_or(0.0));
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  CLI::App app;
  Arguments arguments;
  define(app, arguments);
  // Extras are collected, not thrown by CLI11: its errors know no suggestions.
  app.allow_extras();
  for (auto* sub : app.get_subcommands(nullptr)) sub->allow_extras();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    if (app.remaining_size(true) > 0) refuse_extra(app);  // a mistyped option is more likely than a missing one
    throw ConfigError(std::string(error.what()) + " (ricochet --help)");
  }
  if (app.remaining_size(true) > 0) refuse_extra(app);
  if (app.got_subcommand("run")) run_scene(arguments.scene, arguments.out);
  if (app.got_subcommand("check")) check_scene(arguments.scene);
  if (app.got_subcommand("stability")) study_stability(arguments.stability);
  if (app.got_subcommand("study")) run_study(arguments.study, arguments.out);
  if (app.got_subcommand("report")) write_report(arguments.results);
  if (app.got_subcommand("init")) fmt::print("wrote {}\n", write_starter_scene(arguments.name));
  if (app.got_subcommand("check-participant") && !check_contract(arguments)) {
    return static_cast<int>(ExitCode::protocol);
  }
  if (app.get_subcommands().empty()) fmt::print("{}", app.help());
  return app.get_subcommands().empty() ? static_cast<int>(ExitCode::config) : 0;
}

}  // namespace ricochet::coupler
