#include "coupler/command/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/base/process.hpp"
#include "coupler/command/advise.hpp"
#include "coupler/command/run_scene.hpp"
#include "coupler/command/slurm_script.hpp"
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
  std::vector<std::string> set;
  ContractRequest contract;
  bool estimate_error = false, picture = false;
  std::optional<double> step_s, until_s;
  std::optional<std::string> time;
  StabilityRequest stability;
  AdviceRequest advice;
};

void define_set(CLI::App& app, Arguments& arguments) {
  app.add_option("--set", arguments.set,
                 "Set a key of the scene, as time.step_s=1e-7 or coupling.protocol=kim; may be repeated")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

void define_run(CLI::App& app, Arguments& arguments) {
  define_set(app, arguments);
  app.add_option("SCENE", arguments.scene, "Scene file (TOML)")->required();
  app.add_option("--out", arguments.out, "Results folder; default: out/<name of the scene file>")->type_name("DIR");
  app.add_flag("--estimate-error", arguments.estimate_error,
               "Error bars of the results by cause, from companion runs on coarser meshes and steps");
}

void define_slurm_script(CLI::App& app, Arguments& arguments) {
  app.add_option("SCENE", arguments.scene, "Scene file (TOML)")->required();
  app.add_option("--out", arguments.out, "File for the script; default: standard output")->type_name("FILE");
  app.add_option("--time", arguments.time, "Limit of the job, as Slurm writes times; default: the partition's");
}

void define_check(CLI::App& app, Arguments& arguments) {
  define_set(app, arguments);
  app.add_option("SCENE", arguments.scene, "Scene file (TOML)")->required();
  app.add_flag("--picture", arguments.picture,
               "Draw the scene, too: parts, contact surfaces, interface, supports, loads");
  app.add_option("--out", arguments.out, "Folder of the picture; default: out/<name of the scene file>_scene")
      ->type_name("DIR");
}

void define_advise(CLI::App& app, Arguments& arguments) {
  auto& asked = arguments.advice;
  define_set(app, arguments);
  app.add_option("SCENE", asked.scene.path, "Scene file (TOML)")->required();
  app.add_option("--quantity", asked.quantity, "Which result, as contact_impulse_n_s or peak_contact_force_n")
      ->type_name("NAME");
  app.add_option("--error", asked.error, "Its largest relative error, as 0.01; without both: the table [accuracy]")
      ->type_name("SHARE");
  app.add_option("--out", asked.out, "Folder of the pilot runs; default: out/<name of the scene file>_advice")
      ->type_name("DIR");
}

void define_stability(CLI::App& app, Arguments& arguments) {
  auto& asked = arguments.stability;
  app.add_option("SCENE", asked.scene, "Scene file (TOML)")->required();
  app.add_option("--out", asked.out, "Results folder; default: out/<name of the scene file>_stability")
      ->type_name("DIR");
  app.add_option("--sweep", asked.sweep,
                 "Steps: courant (share of the critical step) or time.step_s =LOW:HIGH:COUNT[:log] or =VALUE,...")
      ->capture_default_str();
  app.add_option("--against", asked.against,
                 "Other parameter: a key of the scene =LOW:HIGH:COUNT[:log] or =VALUE,VALUE,...");
  app.add_flag("--edge", asked.edge, "Bisect the measured edge to 0.5 %");
}

void define_study(CLI::App& app, Arguments& arguments) {
  define_set(app, arguments);
  app.add_option("STUDY", arguments.study, "Study file (TOML)")->required();
  app.add_option("--out", arguments.out, "Results folder; default: out/<name of the study file>")->type_name("DIR");
}

void define_report(CLI::App& app, Arguments& arguments) {
  app.add_option("DIR", arguments.results, "Results folder of a run, a study or a stability map")->required();
}

void define_resume(CLI::App& app, Arguments& arguments) {
  app.add_option("DIR", arguments.results, "Results folder of a run that was interrupted")->required();
  app.add_option("--scene", arguments.scene, "Its scene, which must be named unless you began the run on this machine")
      ->type_name("SCENE");
  app.add_option("--until", arguments.until_s, "Another end than time.end_s of its scene [s]");
  app.add_option("--step", arguments.step_s, "Another step from here on [s]");
}

void define_checkpoint(CLI::App& app, Arguments& arguments) {
  app.add_option("DIR", arguments.results, "Results folder that a run is writing into")->required();
}

void define_contract(CLI::App& app, Arguments& arguments) {
  app.add_option(
      "COMMAND", arguments.contract.command.words,
      "Program and arguments, after --; --connect is appended. Not needed where the scene names the program");
  app.add_option("--scene", arguments.contract.scene,
                 "Scene it takes part in: it is compared with the shipped solver, window by window")
      ->type_name("SCENE");
  app.add_option("--name", arguments.contract.name, "Which participant of the scene it is")->type_name("NAME");
  app.add_option("--step", arguments.step_s, "Window size [s]; default: half of its critical time step");
  app.add_option("--interface-nodes", arguments.contract.interface_nodes,
                 "Write the positions of its interface nodes, as the key interface_nodes of a foreign body reads them")
      ->type_name("FILE");
  app.add_option("--timeout", arguments.contract.command.timeout_s, "Longest wait for an answer [s]")
      ->capture_default_str();
}

void define_init(CLI::App& app, Arguments& arguments) {
  app.add_option("NAME", arguments.name, "Name of the new scene")->required();
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

int check_contract(const Arguments& arguments) {
  const auto require_positive = [](const char* option, double value) {
    if (!(value > 0.0)) throw ConfigError(fmt::format("{}: found {}, allowed: a number of seconds > 0", option, value));
  };
  ContractRequest request = arguments.contract;
  require_positive("--timeout", request.command.timeout_s);
  if (arguments.step_s) require_positive("--step", *arguments.step_s);
  if (request.scene.empty() != request.name.empty())
    throw ConfigError("--scene and --name: found one of them, allowed: both, or none");
  if (request.scene.empty() && request.command.words.empty())
    throw ConfigError("COMMAND is required, after --, unless --scene and --name say what to start");
  request.window_size_s = arguments.step_s.value_or(0.0);
  const bool passed = check_participant(request);
  return static_cast<int>(passed ? ExitCode::done : ExitCode::protocol);
}

/// The arguments that may follow the command's name.
struct Subcommand {
  const char* name;
  const char* description;
  void (*define)(CLI::App& app, Arguments& arguments);
  int (*run)(const Arguments& arguments);  ///< returns the exit code; null: known to the script ./ricochet alone
};

/// The callback of a subcommand that ends with exit code 0 or throws.
template <auto action>
int done(const Arguments& arguments) {
  action(arguments);
  return 0;
}

const Subcommand subcommands[] = {
    {"run", "Compute a scene: start its participants, couple them, write the results", define_run,
     done<[](const Arguments& a) {
       run_scene({a.scene, a.set}, a.out, a.estimate_error);
     }>},
    {"resume", "Go on with a run from its last checkpoint, to the same numbers", define_resume,
     done<[](const Arguments& a) { resume_run(a.results, a.scene, a.until_s, a.step_s); }>},
    {"checkpoint", "Have a run that goes on save all that it would go on from", define_checkpoint,
     done<[](const Arguments& a) { request_checkpoint(a.results); }>},
    {"slurm-script", "Write the batch script that computes a scene on Slurm, from limit to limit", define_slurm_script,
     done<[](const Arguments& a) { write_slurm_script(a.scene, a.out, a.time); }>},
    {"check", "Report and refuse all that can be known before a process starts", define_check,
     done<[](const Arguments& a) {
       if (!a.picture && !a.out.empty()) throw ConfigError("--out: found without --picture, allowed: with it");
       check_scene({a.scene, a.set}, a.picture ? std::optional(a.out) : std::nullopt);
     }>},
    {"advise", "Say which protocol and step reach an error in the least time", define_advise,
     done<[](const Arguments& a) {
       AdviceRequest request = a.advice;
       request.scene.set = a.set;
       advise(request);
     }>},
    {"stability", "Measure at which steps the coupled scheme is stable", define_stability,
     done<[](const Arguments& a) { study_stability(a.stability); }>},
    {"study", "Compute a scene by many methods and settings: error against time", define_study,
     done<[](const Arguments& a) { run_study(a.study, a.out, a.set); }>},
    {"report", "Write the charts once more: DIR/report.html, and each as a picture in DIR/charts", define_report,
     done<[](const Arguments& a) { write_report(a.results); }>},
    {"check-participant", "Run a program through the contract of docs/participants.md", define_contract,
     check_contract},
    {"init", "Write a commented starter scene NAME.toml", define_init,
     done<[](const Arguments& a) { fmt::print("wrote {}\n", write_starter_scene(a.name)); }>},
    {"test", "Build and run all tests (only ./ricochet, in the folder of the sources)", nullptr, nullptr},
    {"bench", "Build and measure the benchmarks (only ./ricochet, in the folder of the sources)", nullptr, nullptr},
};

void define(CLI::App& app, Arguments& arguments) {
  app.name(command_name);
  app.description("Hybrid implicit-explicit analysis of dynamic contact by impact.");
  app.footer(exit_codes);
  app.set_version_flag("--version", fmt::format("{} {}", command_name, RICOCHET_VERSION));
  app.require_subcommand(0, 1);
  for (const auto& subcommand : subcommands) {
    auto* defined = app.add_subcommand(subcommand.name, subcommand.description);
    if (subcommand.define) subcommand.define(*defined, arguments);
  }
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// Refuses a word that CLI11 could not place: an unknown command, or an unknown option of the command that was given.
[[noreturn]] void refuse_extra(const CLI::App& app) {
  const auto named = app.get_subcommands();
  const CLI::App& command = named.empty() ? app : *named.front();
  auto extras = command.remaining();
  if (extras.empty()) extras = app.remaining();
  const std::string extra = extras.empty() ? "" : extras.front();
  if (named.empty() && extra.rfind('-', 0) != 0) {
    std::vector<std::string> commands;
    for (const auto* sub : app.get_subcommands(nullptr)) commands.push_back(sub->get_name());
    throw ConfigError(fmt::format("unknown command \"{}\", allowed are {}{}", extra, fmt::join(commands, ", "),
                                  did_you_mean(extra, commands)));
  }
  const auto known = option_names(command);
  throw ConfigError(fmt::format("unexpected argument \"{}\", allowed options are {}{}", extra, fmt::join(known, ", "),
                                did_you_mean(extra, known)));
}

/// The subcommand that was given; null if none was.
const Subcommand* given(const CLI::App& app) {
  for (const auto& subcommand : subcommands) {
    if (app.got_subcommand(subcommand.name)) return &subcommand;
  }
  return nullptr;
}

void refuse_if_of_script(const Subcommand* subcommand) {
  if (!subcommand || subcommand->run) return;
  throw ConfigError(
      fmt::format("\"{0}\" is a command of the script ./{1} in the folder of the sources, which builds "
                  "before: ./{1} {0}",
                  subcommand->name, command_name));
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
    throw ConfigError(fmt::format("{} ({} --help)", error.what(), command_name));
  }
  const auto* subcommand = given(app);
  refuse_if_of_script(subcommand);
  if (app.remaining_size(true) > 0) refuse_extra(app);
  if (subcommand) return subcommand->run(arguments);
  fmt::print("{}", app.help());
  return static_cast<int>(ExitCode::config);
}

}  // namespace ricochet::coupler
