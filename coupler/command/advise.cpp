#include "coupler/command/advise.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"
#include "coupler/command/method_choice.hpp"
#include "coupler/processes/machine_check.hpp"

namespace ricochet::coupler {
namespace {

AskedErrors asked_by(const AdviceRequest& request, const scene::Scene& scene) {
  if (request.quantity.has_value() != request.error.has_value())
    throw ConfigError(
        "--quantity and --error: found one of them, allowed: both, or none where the scene has [accuracy]");
  if (!request.quantity) {
    if (!scene.accuracy.empty()) return scene.accuracy;
    throw ConfigError(scene.path + ": found no table [accuracy]; allowed: one, or --quantity NAME --error SHARE");
  }
  if (!(*request.error > 0.0 && *request.error < 1.0))
    throw ConfigError(fmt::format("--error: found {:g}, allowed: a share between 0 and 1, as 0.01", *request.error));
  return {{*request.quantity, *request.error}};
}

void print(const MethodChoice& choice, const AskedErrors& asked) {
  fmt::print("{}\n{}, from {} pilot runs in {:.2g} s\n", to_table(choice, asked), to_text(asked), choice.pilots,
             choice.pilots_s);
  std::fflush(stdout);
}

std::string command_of(GivenScene given, const scene::Scene& scene, const Proposal& proposal) {
  given.add(proposal.changes(scene));
  return fmt::format("{} run {} --set {}", command_name, given.path, fmt::join(given.set, " --set "));
}

}  // namespace

void advise(const AdviceRequest& request) {
  auto problem = request.scene.load();
  const auto asked = asked_by(request, problem.scene);
  const bool in_scene = !request.quantity;
  require_choice(problem, asked, in_scene ? "accuracy" : "advise");
  std::vector<std::string> files{"advice.csv"};
  if (!request.scene.set.empty()) files.push_back(changed_scene_name(request.scene.path));
  const std::string stem = std::filesystem::path(request.scene.path).stem().string();
  const ResultsDirectory results(request.out.empty() ? "out/" + stem + "_advice" : request.out, files,
                                 {request.scene.path});
  if (!request.scene.set.empty())
    problem = load_problem(write_changed_scene(request.scene.path, request.scene.changes(), results.path()));
  const auto choice = choose_method(request.scene, problem, asked,
                                    in_scene ? open_in_scene(problem) : any_method(problem), results.file("pilots"));
  write_atomically(results.file("advice.csv"), to_csv(choice, asked));
  print(choice, asked);
  if (!choice.best) refuse_unreached(problem, choice, asked, in_scene);
  const auto command = [&](std::size_t i) {
    return printable(command_of(request.scene, problem.scene, choice.proposals[i]));
  };
  fmt::print("least time: {}\n", command(*choice.best));
  fmt::print("next:       {}\n", choice.next ? command(*choice.next) : "none by another protocol");
  fmt::print("all candidates: {}\n", printable(results.file("advice.csv")));
}

ChosenByAccuracy choose_by_accuracy(const scene::Problem& problem, const ResultsDirectory& results) {
  const auto& scene = problem.scene;
  require_choice(problem, scene.accuracy, "accuracy");
  // Where the error bars of the run find them.
  auto freedom = open_in_scene(problem);
  freedom.with_next = false;
  const auto choice = choose_method({scene.path}, problem, scene.accuracy, freedom, results.file("accuracy"));
  write_atomically(results.file("advice.csv"), to_csv(choice, scene.accuracy));
  print(choice, scene.accuracy);
  if (!choice.best) refuse_unreached(problem, choice, scene.accuracy, true);
  const auto& best = choice.proposals[*choice.best];
  ChosenByAccuracy chosen{write_changed_scene(scene.path, best.changes(scene), results.path()), {}};
  for (const auto& [quantity, bar] : best.bars) chosen.expected[quantity] = bar.relative;
  return chosen;
}

}  // namespace ricochet::coupler
