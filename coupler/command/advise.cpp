#include "coupler/command/advise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <new>
#include <optional>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"
#include "common/check/check.hpp"
#include "common/cost/predicted_cost.hpp"
#include "coupler/command/announcer.hpp"
#include "coupler/command/cost_text.hpp"
#include "coupler/command/impact_text.hpp"
#include "coupler/processes/machine_check.hpp"
#include "coupler/results/csv_cell.hpp"
#include "coupler/results/results_directory.hpp"
#include "coupler/results/theory.hpp"
#include "coupler/study/companions.hpp"
#include "coupler/study/error_bar.hpp"

namespace ricochet::coupler {
namespace {

/// Steps that are tried, over that of the scene. A step that is refused or unstable costs no more than its pilot.
constexpr double step_factors[] = {16.0, 8.0, 4.0, 2.0, 1.0, 0.5};

/// The coarsest pilot of a contact has five windows of it: with fewer the bar is chance.
constexpr double least_steps_of_contact = 40.0;

struct Proposal {
  std::string protocol;
  double step_s = 0.0, predicted_s = 0.0;
  std::string refused{};                 ///< why it cannot be run, or has no bar
  std::optional<double> bar{}, order{};  ///< relative; empty: no pilot was computed
  [[nodiscard]] bool runs() const { return refused.empty(); }
};

/// The first line without the place in a scene file that a pilot was written to.
std::string reason_of(const std::string& error) {
  const std::string line = error.substr(0, error.find('\n'));
  const auto place = line.find("scene.toml:");
  return place == std::string::npos ? line : line.substr(line.find(' ', place) + 1);
}

std::vector<std::string> settings_of(const Proposal& proposal) {
  return {"coupling.protocol=" + proposal.protocol, fmt::format("time.step_s={:.6g}", proposal.step_s)};
}

/// Predicts what the proposal costs on the scene's own mesh; says why it is refused.
void predict(const AdviceRequest& request, const cost::MachineSpeed& speed, Proposal& proposal) {
  GivenScene given = request.scene;
  for (auto& setting : settings_of(proposal)) given.set.push_back(std::move(setting));
  try {
    const auto problem = given.load();
    const auto plan = scene::plan(problem);
    const auto cost =
        cost::predict_cost(problem, plan, expected_end_s(problem), speed, contact_durations_s(problem, plan));
    proposal.predicted_s = cost.setup_s + cost.stepping_s();
  } catch (const Error& error) {
    proposal.refused = reason_of(error.what());
  } catch (const std::bad_alloc&) {
    proposal.refused = "its factor does not fit into memory";
  }
}

std::vector<Proposal> find_proposals(const AdviceRequest& request, const scene::Problem& problem,
                                     const scene::Plan& plan) {
  const auto speed = cost::measure_speed();
  const auto here = cost::predict_cost(problem, plan, expected_end_s(problem), speed);
  const auto& own = problem.scene.coupling.protocol;
  std::vector<std::string> stepped{"all_implicit"};
  if (here.local_explicit_s > 0.0 && !own.local_steps) stepped.emplace_back("local_explicit");
  if (own.coupled() || own.local_steps) stepped.push_back(own.name);
  std::vector<Proposal> proposals{{"all_explicit", here.all_explicit_step_s}};
  for (const auto& protocol : stepped) {
    for (const double factor : step_factors) {
      const double step_s = factor * problem.clock.size_s(1);
      const bool is_all_explicit = protocol == "local_explicit" && step_s <= here.all_explicit_step_s * (1.0 + 1e-9);
      if (!is_all_explicit) proposals.push_back({protocol, step_s});
    }
  }
  for (auto& proposal : proposals) predict(request, speed, proposal);
  std::stable_sort(proposals.begin(), proposals.end(), [](const Proposal& a, const Proposal& b) {
    return a.runs() != b.runs() ? a.runs() : a.predicted_s < b.predicted_s;
  });
  return proposals;
}

/// The bar on the elements and step of the scene, from that on elements and step of twice the length.
double expected_bar(double coarse_bar, const std::optional<double>& order) {
  return order ? coarse_bar / std::exp2(std::min(*order, 1.0)) : coarse_bar;
}

/// Bars of proposals on the scene's mesh, from their pilots on coarser ones.
class Pilots {
 public:
  Pilots(const scene::Scene& scene, const AdviceRequest& request, const ResultsDirectory& results)
      : scene_(scene), request_(request), runs_(scene, results.file("pilots")) {}

  void measure(Proposal& proposal) {
    QuantityLevels levels;
    levels.floor = floor_of(request_.quantity, 2.0 * proposal.step_s);
    const auto first = run(proposal, 2);
    if (!first.error.empty()) {
      proposal.refused = "with elements and step doubled: " + reason_of(first.error);
      return;
    }
    require_quantity(first);
    if (const auto contact_s = first.value("contact_duration_s");
        contact_s && *contact_s < least_steps_of_contact * proposal.step_s) {
      proposal.refused = fmt::format("the contact lasts {:.0f} steps, and a bar needs {:g}",
                                     *contact_s / proposal.step_s, least_steps_of_contact);
      return;
    }
    levels.run = *first.value(request_.quantity);
    levels.coarse = run(proposal, 4).value(request_.quantity);
    levels.coarsest = run(proposal, 8).value(request_.quantity);
    const ErrorBar bar = error_bar(levels);
    if (!bar.total || levels.run == 0.0) {
      proposal.refused = "a coarser mesh has no such value";
      return;
    }
    proposal.order = bar.order;
    proposal.bar = expected_bar(*bar.total, bar.order) / std::abs(levels.run);
  }
  [[nodiscard]] std::size_t count() const { return runs_.all().size(); }
  [[nodiscard]] double wall_s() const {
    double sum_s = 0.0;
    for (const auto& run : runs_.all()) sum_s += run.wall_s;
    return sum_s;
  }

 private:
  Companion run(const Proposal& proposal, int factor) {
    return runs_.compute(fmt::format("{} {}", proposal.protocol, factor),
                         with(*coarser(scene_, factor),
                              {{"coupling.protocol", proposal.protocol}, {"time.step_s", factor * proposal.step_s}}));
  }
  void require_quantity(const Companion& run) const {
    if (run.value(request_.quantity)) return;
    std::vector<std::string> known;
    for (const auto& [name, value] : run.values) known.push_back(name);
    throw ConfigError(fmt::format("--quantity: found \"{}\", allowed: {}{}", request_.quantity, fmt::join(known, ", "),
                                  did_you_mean(request_.quantity, known)));
  }

  const scene::Scene& scene_;
  const AdviceRequest& request_;
  Companions runs_;
};

struct Choice {
  const Proposal *best = nullptr, *next = nullptr;  ///< next: the cheapest by another protocol that reaches the error
};

/// Pilots in the order of predicted times, no more than are needed.
Choice choose(std::vector<Proposal>& proposals, double error, Pilots& pilots) {
  Choice choice;
  for (auto& proposal : proposals) {
    if (!proposal.runs() || (choice.best && proposal.protocol == choice.best->protocol)) continue;
    pilots.measure(proposal);
    if (!proposal.bar || *proposal.bar > error) continue;
    (choice.best ? choice.next : choice.best) = &proposal;
    if (choice.next) break;
  }
  return choice;
}

std::string to_csv(const std::vector<Proposal>& proposals) {
  std::string text = "protocol,step_s,predicted_s,expected_error,order,refused\n";
  const auto cell = [](const std::optional<double>& x) { return x ? fmt::format("{:.6g}", *x) : std::string(); };
  for (const auto& c : proposals)
    text += fmt::format("{},{:.6g},{},{},{},{}\n", c.protocol, c.step_s,
                        c.predicted_s > 0.0 ? fmt::format("{:.6g}", c.predicted_s) : "", cell(c.bar), cell(c.order),
                        csv_cell(c.refused));
  return text;
}

std::string to_table(const std::vector<Proposal>& proposals, const Choice& choice) {
  std::string text =
      fmt::format("{:<20} {:>11} {:>14} {:>15}\n", "protocol", "step [s]", "predicted [s]", "expected error");
  for (const auto& c : proposals) {
    const std::string mark = &c == choice.best ? "  best" : &c == choice.next ? "  next" : "";
    if (c.bar) {
      text += fmt::format("{:<20} {:>11.4g} {:>14.3g} {:>13.2g} %{}\n", c.protocol, c.step_s, c.predicted_s,
                          100.0 * *c.bar, mark);
    } else if (!c.refused.empty() && c.predicted_s > 0.0) {
      text += fmt::format("{:<20} {:>11.4g} {:>14.3g}  {}\n", c.protocol, c.step_s, c.predicted_s, c.refused);
    }
  }
  return text;
}

/// The next number above of one digit.
double rounded_up(double value) {
  const double digit = std::pow(10.0, std::floor(std::log10(value)));
  return std::ceil(value / digit) * digit;
}

/// No candidate reaches the error: how much finer the elements would have to be, at the order that was seen.
[[noreturn]] void refuse(const AdviceRequest& request, const std::vector<Proposal>& proposals) {
  const Proposal* least = nullptr;
  for (const auto& c : proposals)
    if (c.bar && (!least || *c.bar < *least->bar)) least = &c;
  if (!least) {
    const auto tried = std::find_if(proposals.begin(), proposals.end(), [](const Proposal& p) { return !p.runs(); });
    throw ConfigError(fmt::format("{}: no protocol and step can be tried on coarser meshes: {}", request.scene.path,
                                  tried == proposals.end() ? "none has a bar" : tried->refused));
  }
  const double order = std::clamp(least->order.value_or(1.0), 0.5, 1.0);
  throw ConfigError(fmt::format(
      "{}: no protocol and step is expected to have {} within {:g} % on this mesh; found {:.2g} % at the least, by {} "
      "in steps of {:.4g} s. Type --error {:.1g}, or make elements {:.2g} times shorter",
      request.scene.path, request.quantity, 100.0 * request.error, 100.0 * *least->bar, least->protocol, least->step_s,
      rounded_up(*least->bar), std::pow(*least->bar / request.error, 1.0 / order)));
}

std::string command_of(const AdviceRequest& request, const Proposal& proposal) {
  std::string text = fmt::format("{} run {}", command_name, request.scene.path);
  for (const auto& setting : request.scene.set) text += " --set " + setting;
  for (const auto& setting : settings_of(proposal)) text += " --set " + setting;
  return text;
}

void require_answerable(const AdviceRequest& request, const scene::Problem& problem) {
  const scene::Scene& scene = problem.scene;
  if (!(request.error > 0.0 && request.error < 1.0))
    throw ConfigError(fmt::format("--error: found {:g}, allowed: a share between 0 and 1, as 0.01", request.error));
  require_companions(scene, "advise");
  if (!coarser(scene, 2))
    throw ConfigError(scene.path +
                      ": advise: found a mesh of a file; allowed: meshes by elements, which it can coarsen");
  if (request.quantity.rfind("peak_contact_force_n", 0) == 0 && impact_theory(problem))
    throw ConfigError(
        fmt::format("--quantity: found \"{}\" of a flat impact, whose front overshoots on every mesh; allowed: "
                    "contact_impulse_n_s, plateau_stress_pa and others that a front does not decide",
                    request.quantity));
}

}  // namespace

void advise(const AdviceRequest& request) {
  auto problem = request.scene.load();
  require_answerable(request, problem);
  std::vector<std::string> files{"advice.csv"};
  if (!request.scene.set.empty()) files.push_back(changed_scene_name(request.scene.path));
  const std::string stem = std::filesystem::path(request.scene.path).stem().string();
  const ResultsDirectory results(request.out.empty() ? "out/" + stem + "_advice" : request.out, files,
                                 {request.scene.path});
  if (!request.scene.set.empty())
    problem = load_problem(write_changed_scene(request.scene.path, request.scene.changes(), results.path()));
  std::vector<Proposal> proposals;
  {
    Announcer announcer;
    announcer.begin("predicting the cost of each protocol and step");
    proposals = find_proposals(request, problem, scene::plan(problem));
  }
  Pilots pilots(problem.scene, request, results);
  const Choice choice = choose(proposals, request.error, pilots);
  write_atomically(results.file("advice.csv"), to_csv(proposals));
  fmt::print("{}\n{} within {:g} %, from {} pilot runs in {:.2g} s\n", to_table(proposals, choice), request.quantity,
             100.0 * request.error, pilots.count(), pilots.wall_s());
  std::fflush(stdout);
  if (!choice.best) refuse(request, proposals);
  fmt::print("least time: {}\n", printable(command_of(request, *choice.best)));
  fmt::print("next:       {}\n",
             choice.next ? printable(command_of(request, *choice.next)) : "none by another protocol");
  fmt::print("all candidates: {}\n", printable(results.file("advice.csv")));
}

}  // namespace ricochet::coupler
