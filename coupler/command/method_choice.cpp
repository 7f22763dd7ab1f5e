#include "coupler/command/method_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/check/check.hpp"
#include "common/cost/predicted_cost.hpp"
#include "coupler/command/announcer.hpp"
#include "coupler/command/cost_text.hpp"
#include "coupler/command/impact_text.hpp"
#include "coupler/results/csv_cell.hpp"
#include "coupler/results/theory.hpp"
#include "coupler/study/companions.hpp"
#include "coupler/study/error_bar.hpp"

namespace ricochet::coupler {
namespace {

/// Over the scene's step. A step that is refused or unstable costs no more than its pilot.
constexpr double step_factors[] = {16.0, 8.0, 4.0, 2.0, 1.0, 0.5};

/// The coarsest pilot of a contact has five windows of it: with fewer the bar is chance.
constexpr double least_steps_of_contact = 40.0;

/// The first line without the place in the scene file that was written for it.
std::string reason_of(const std::string& error) {
  const std::string line = error.substr(0, error.find('\n'));
  const auto place = line.find(".toml:");
  return place == std::string::npos ? line : line.substr(line.find(' ', place) + 1);
}

/// Predicts what the proposal costs on the scene's own mesh; says why it is refused.
void predict(GivenScene given, const cost::MachineSpeed& speed, Proposal& proposal) {
  given.set.push_back("coupling.protocol=" + proposal.protocol);
  given.set.push_back(fmt::format("time.step_s={:.17g}", proposal.step_s));
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

/// What baselines would cost. Where the scene leaves the protocol open, its step may be one that the default protocol
/// does not bear.
cost::PredictedCost predict_baselines(GivenScene given, const scene::Problem& problem,
                                      const cost::MachineSpeed& speed) {
  const auto predicted = [&](const scene::Problem& of) {
    return cost::predict_cost(of, scene::plan(of), expected_end_s(of), speed);
  };
  if (problem.scene.protocol_given()) return predicted(problem);
  try {
    return predicted(problem);
  } catch (const ConfigError&) {
    given.set.emplace_back("coupling.protocol=all_implicit");
    return predicted(given.load());
  }
}

std::vector<Proposal> find_proposals(const GivenScene& given, const scene::Problem& problem, const Freedom& freedom) {
  const auto speed = cost::measure_speed();
  const auto here = predict_baselines(given, problem, speed);
  const auto& own = problem.scene.coupling.protocol;
  auto protocols = freedom.protocols;
  if (protocols.empty()) {
    protocols = {"all_explicit", "all_implicit"};
    if (here.local_explicit_s > 0.0 && !own.local_steps) protocols.emplace_back("local_explicit");
    if (own.coupled() || own.local_steps) protocols.push_back(own.name);
  }
  std::vector<Proposal> proposals;
  for (const auto& protocol : protocols) {
    if (protocol == "all_explicit" && !freedom.explicit_step) {
      proposals.push_back({protocol, here.all_explicit_step_s});
      continue;
    }
    for (const double step_s : freedom.steps_s) {
      const bool is_all_explicit = protocol == "local_explicit" && step_s <= here.all_explicit_step_s * (1.0 + 1e-9);
      if (!is_all_explicit || protocols.size() == 1) proposals.push_back({protocol, step_s});
    }
  }
  for (auto& proposal : proposals) predict(given, speed, proposal);
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
  Pilots(const scene::Scene& scene, const AskedErrors& asked, const std::string& folder)
      : scene_(scene), asked_(asked), runs_(scene, folder) {}

  void measure(Proposal& proposal) {
    const auto first = run(proposal, 2);
    if (!first.error.empty()) {
      proposal.refused = "with elements and step doubled: " + reason_of(first.error);
      return;
    }
    for (const auto& [quantity, error] : asked_) {
      if (first.value(quantity)) continue;
      proposal.refused = fmt::format("with elements and step doubled it has no {}", quantity);
      return;
    }
    if (const auto contact_s = first.value("contact_duration_s");
        contact_s && *contact_s < least_steps_of_contact * proposal.step_s) {
      proposal.refused = fmt::format("the contact lasts {:.0f} steps, and a bar needs {:g}",
                                     *contact_s / proposal.step_s, least_steps_of_contact);
      return;
    }
    const auto second = run(proposal, 4), third = run(proposal, 8);
    for (const auto& [quantity, error] : asked_) {
      QuantityLevels levels;
      levels.floor = floor_of(quantity, 2.0 * proposal.step_s);
      levels.run = *first.value(quantity);
      levels.coarse = second.value(quantity);
      levels.coarsest = third.value(quantity);
      const ErrorBar bar = error_bar(levels);
      if (!bar.total || levels.run == 0.0) {
        proposal.refused = fmt::format("a coarser mesh has no {}", quantity);
        proposal.bars.clear();
        return;
      }
      proposal.bars[quantity] = {expected_bar(*bar.total, bar.order) / std::abs(levels.run), bar.order};
    }
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

  const scene::Scene& scene_;
  const AskedErrors& asked_;
  Companions runs_;
};

/// How far a proposal is from what is asked: its largest bar over the error; above 1 it does not reach it.
double worst_ratio(const Proposal& proposal, const AskedErrors& asked) {
  double worst = 0.0;
  for (const auto& [quantity, bar] : proposal.bars) worst = std::max(worst, bar.relative / asked.at(quantity));
  return worst;
}

/// The next number above of one digit.
double rounded_up(double value) {
  const double digit = std::pow(10.0, std::floor(std::log10(value)));
  return std::ceil(value / digit) * digit;
}

}  // namespace

bool Proposal::reaches(const AskedErrors& asked) const { return !bars.empty() && worst_ratio(*this, asked) <= 1.0; }

Freedom any_method(const scene::Problem& problem) {
  Freedom freedom;
  for (const double factor : step_factors) freedom.steps_s.push_back(factor * problem.clock.size_s(1));
  return freedom;
}

Freedom open_in_scene(const scene::Problem& problem) {
  const auto& scene = problem.scene;
  Freedom freedom = any_method(problem);
  if (scene.protocol_given()) freedom.protocols = {scene.coupling.protocol.name};
  if (scene.time.largest_step_s) {
    for (double& step_s : freedom.steps_s) step_s /= step_factors[0];
  } else if (scene.time.step_s) {
    freedom.steps_s = {*scene.time.step_s};
    freedom.explicit_step = true;
  }
  return freedom;
}

/// Pilots in the order of predicted times, no more than are needed.
MethodChoice choose_method(const GivenScene& given, const scene::Problem& problem, const AskedErrors& asked,
                           const Freedom& freedom, const std::string& folder) {
  MethodChoice choice;
  {
    Announcer announcer;
    announcer.begin("predicting the cost of each protocol and step");
    choice.proposals = find_proposals(given, problem, freedom);
  }
  Pilots pilots(problem.scene, asked, folder);
  for (std::size_t i = 0; i < choice.proposals.size() && !choice.next; ++i) {
    auto& proposal = choice.proposals[i];
    if (!proposal.runs() || (choice.best && proposal.protocol == choice.proposals[*choice.best].protocol)) continue;
    pilots.measure(proposal);
    if (proposal.reaches(asked)) (choice.best ? choice.next : choice.best) = i;
  }
  choice.pilots = pilots.count();
  choice.pilots_s = pilots.wall_s();
  return choice;
}

void require_choice(const scene::Problem& problem, const AskedErrors& asked, const std::string& asked_by) {
  const scene::Scene& scene = problem.scene;
  const auto known = scene.quantities_with_bars();
  for (const auto& [quantity, error] : asked) {
    if (std::find(known.begin(), known.end(), quantity) == known.end())
      throw ConfigError(fmt::format("--quantity: found \"{}\", allowed: {}{}", quantity, fmt::join(known, ", "),
                                    did_you_mean(quantity, known)));
  }
  require_companions(scene, asked_by);
  if (!coarser(scene, 2))
    throw ConfigError(fmt::format("{}: {}: found a mesh of a file; allowed: meshes by elements, which it can coarsen",
                                  scene.path, asked_by));
  if (!impact_theory(problem)) return;
  for (const auto& [quantity, error] : asked) {
    if (quantity.rfind("peak_contact_force_n", 0) == 0)
      throw ConfigError(
          fmt::format("{}: {}: found \"{}\" of a flat impact, whose front overshoots on every mesh; allowed: "
                      "contact_impulse_n_s, plateau_stress_pa and others that a front does not decide",
                      scene.path, asked_by, quantity));
  }
}

void refuse_unreached(const scene::Problem& problem, const MethodChoice& choice, const AskedErrors& asked,
                      bool in_scene) {
  const auto& proposals = choice.proposals;
  const Proposal* least = nullptr;
  for (const auto& p : proposals)
    if (!p.bars.empty() && (!least || worst_ratio(p, asked) < worst_ratio(*least, asked))) least = &p;
  if (!least) {
    const auto tried = std::find_if(proposals.begin(), proposals.end(), [](const Proposal& p) { return !p.runs(); });
    throw ConfigError(fmt::format("{}: no protocol and step can be tried on coarser meshes: {}", problem.scene.path,
                                  tried == proposals.end() ? "none has a bar" : tried->refused));
  }
  const auto worst = std::max_element(least->bars.begin(), least->bars.end(), [&](const auto& a, const auto& b) {
    return a.second.relative / asked.at(a.first) < b.second.relative / asked.at(b.first);
  });
  const auto& [quantity, bar] = *worst;
  const double order = std::clamp(bar.order.value_or(1.0), 0.5, 1.0);
  const std::string less = fmt::format("{:.1g}", rounded_up(bar.relative));
  throw ConfigError(fmt::format(
      "{}: no protocol and step is expected to have {} within {:g} % on this mesh; found {:.2g} % at the least, by {} "
      "in steps of {:.4g} s. Type {}, or make elements {:.2g} times shorter",
      problem.scene.path, quantity, 100.0 * asked.at(quantity), 100.0 * bar.relative, least->protocol, least->step_s,
      in_scene ? fmt::format("relative_error = {{ \"{}\" = {} }}", quantity, less) : "--error " + less,
      std::pow(bar.relative / asked.at(quantity), 1.0 / order)));
}

std::string to_csv(const MethodChoice& choice, const AskedErrors& asked) {
  std::string text = "protocol,step_s,predicted_s";
  for (const auto& [quantity, error] : asked) text += fmt::format(",expected_error/{0},order/{0}", quantity);
  text += ",refused\n";
  for (const auto& p : choice.proposals) {
    text += fmt::format("{},{:.6g},{}", p.protocol, p.step_s,
                        p.predicted_s > 0.0 ? fmt::format("{:.6g}", p.predicted_s) : "");
    for (const auto& [quantity, error] : asked) {
      const auto bar = p.bars.find(quantity);
      if (bar == p.bars.end()) {
        text += ",,";
      } else {
        text += fmt::format(",{:.6g},{}", bar->second.relative,
                            bar->second.order ? fmt::format("{:.6g}", *bar->second.order) : "");
      }
    }
    text += "," + csv_cell(p.refused) + "\n";
  }
  return text;
}

std::string to_table(const MethodChoice& choice, const AskedErrors& asked) {
  std::string text = fmt::format("{:<20} {:>11} {:>14}", "protocol", "step [s]", "predicted [s]");
  for (const auto& [quantity, error] : asked)
    text += fmt::format("  {}", asked.size() == 1 ? " expected error" : "error of " + quantity);
  text += "\n";
  for (std::size_t i = 0; i < choice.proposals.size(); ++i) {
    const auto& p = choice.proposals[i];
    if (p.bars.empty() && (p.refused.empty() || p.predicted_s == 0.0)) continue;
    text += fmt::format("{:<20} {:>11.4g} {:>14.3g}", p.protocol, p.step_s, p.predicted_s);
    for (const auto& [quantity, bar] : p.bars) {
      const std::size_t width = asked.size() == 1 ? 15 : quantity.size() + 9;
      text += fmt::format("  {:>{}.2g} %", 100.0 * bar.relative, width - 2);
    }
    if (p.bars.empty()) text += "  " + p.refused;
    text += i == choice.best ? "  best\n" : i == choice.next ? "  next\n" : "\n";
  }
  return text;
}

std::string to_text(const AskedErrors& asked) {
  std::string text;
  for (const auto& [quantity, error] : asked)
    text += fmt::format("{}{} within {:g} %", text.empty() ? "" : ", ", quantity, 100.0 * error);
  return text;
}

}  // namespace ricochet::coupler
