#include "coupler/command/method_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "coupler/command/candidates.hpp"
#include "coupler/results/theory.hpp"
#include "coupler/study/companions.hpp"
#include "coupler/study/error_bar.hpp"

namespace ricochet::coupler {
namespace {

/// Over the scene's step. A step that is refused or unstable costs no more than its pilot.
constexpr double step_factors[] = {16.0, 8.0, 4.0, 2.0, 1.0, 0.5};

/// The coarsest pilot of a contact has five windows of it: with fewer the bar is chance.
constexpr double least_steps_of_contact = 40.0;

/// The bar on the elements and step of the scene, from that on elements and step of twice the length.
double expected_bar(double coarse_bar, const std::optional<double>& order) {
  return order ? coarse_bar / std::exp2(std::min(*order, 1.0)) : coarse_bar;
}

/// Bars of proposals on their meshes, from their pilots on coarser ones.
class Pilots {
 public:
  Pilots(const scene::Scene& scene, const AskedErrors& asked, const std::string& folder)
      : scene_(scene), asked_(asked), runs_(scene, folder) {}

  /// The coarsest first: where it fails no other is computed.
  void measure(Proposal& proposal) {
    std::map<int, Companion> levels;
    for (const int factor : {coarsest_pilot, 4, 2}) {
      auto& run = levels[factor] = compute(proposal, factor);
      proposal.refused = why_no_bar(run, factor, proposal.step_s);
      if (!proposal.runs()) return;
    }
    for (const auto& [quantity, error] : asked_) {
      QuantityLevels values;
      values.floor = floor_of(quantity, 2.0 * proposal.step_s);
      values.run = *levels[2].value(quantity);
      values.coarse = levels[4].value(quantity);
      values.coarsest = levels[coarsest_pilot].value(quantity);
      const ErrorBar bar = error_bar(values);
      proposal.bars[quantity] = {expected_bar(*bar.total, bar.order) / std::abs(values.run), bar.order};
    }
  }
  [[nodiscard]] std::size_t count() const { return runs_.all().size(); }
  [[nodiscard]] double wall_s() const {
    double sum_s = 0.0;
    for (const auto& run : runs_.all()) sum_s += run.wall_s;
    return sum_s;
  }

 private:
  Companion compute(const Proposal& proposal, int factor) {
    return runs_.compute(fmt::format("{} {}", proposal.protocol, factor), proposal.changes(scene_, factor));
  }

  /// Empty: the proposal may have a bar. `step_s`: of the proposal, not of this pilot.
  [[nodiscard]] std::string why_no_bar(const Companion& run, int factor, double step_s) const {
    const std::string which = with_times(factor);
    if (!run.error.empty()) return which + ": " + reason_of(run.error);
    for (const auto& [quantity, error] : asked_) {
      const auto value = run.value(quantity);
      if (!value) return fmt::format("{} it has no {}", which, quantity);
      if (factor == 2 && *value == 0.0)  // the bar is relative to this one
        return fmt::format("{} its {} is 0, which has no relative error", which, quantity);
    }
    const auto contact_s = run.value("contact_duration_s");
    if (!contact_s || *contact_s >= least_steps_of_contact * step_s) return {};
    return fmt::format("the contact lasts {:.0f} steps, and a bar needs {:g}", *contact_s / step_s,
                       least_steps_of_contact);
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
    freedom.largest_step_s = scene.time.largest_step_s;
  } else if (scene.time.step_s) {
    freedom.steps_s = {*scene.time.step_s};
    freedom.explicit_step = freedom.one_step = true;
  }
  return freedom;
}

/// Pilots in the order of predicted times, no more than are needed.
MethodChoice choose_method(const GivenScene& given, const scene::Problem& problem, const AskedErrors& asked,
                           const Freedom& freedom, const std::string& folder) {
  Candidates candidates(given, problem, freedom);
  MethodChoice choice;
  auto& tried = choice.proposals;
  Pilots pilots(problem.scene, asked, folder);
  while (!(freedom.with_next ? choice.next : choice.best)) {
    auto proposal = candidates.take_next();
    if (!proposal) break;
    tried.push_back(std::move(*proposal));
    if (choice.best && tried.back().protocol == tried[*choice.best].protocol) continue;
    pilots.measure(tried.back());
    if (tried.back().reaches(asked)) (choice.best ? choice.next : choice.best) = tried.size() - 1;
  }
  for (auto& proposal : candidates.take_rest()) tried.push_back(std::move(proposal));
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
  if (!with_elements(scene, 0.5))
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
    const double finest = 4.0 * problem.scene.elements_times.back();
    const auto tried = std::find_if(proposals.begin(), proposals.end(), [](const Proposal& p) { return !p.runs(); });
    throw ConfigError(fmt::format(
        "{}: no protocol and step can be tried on coarser meshes: {}. {}", problem.scene.path,
        tried == proposals.end() ? "none has a bar" : tried->refused,
        in_scene && finest <= scene::Scene::most_elements_times
            ? fmt::format("Type accuracy.elements_times = [{:g}, {:g}], of which the coarser meshes are finer",
                          0.5 * finest, finest)
            : "Make elements shorter, so that the coarser meshes are finer"));
  }
  const auto worst = std::max_element(least->bars.begin(), least->bars.end(), [&](const auto& a, const auto& b) {
    return a.second.relative / asked.at(a.first) < b.second.relative / asked.at(b.first);
  });
  const auto& [quantity, bar] = *worst;
  const double order = std::clamp(bar.order.value_or(1.0), 0.5, 1.0);
  const std::string less = fmt::format("{:.1g}", rounded_up(bar.relative));
  const double shorter = std::pow(bar.relative / asked.at(quantity), 1.0 / order);
  const double finer = std::exp2(std::ceil(std::log2(least->elements_times * shorter)));
  const bool open = problem.scene.mesh_open();
  throw ConfigError(fmt::format(
      "{}: no protocol and step is expected to have {} within {:g} % on {}; found {:.2g} % at the least, by {} in "
      "steps of {:.4g} s{}. Type {}, or {}",
      problem.scene.path, quantity, 100.0 * asked.at(quantity), open ? "these meshes" : "this mesh",
      100.0 * bar.relative, least->protocol, least->step_s,
      open ? fmt::format(" on elements times {:g}", least->elements_times) : "",
      in_scene ? fmt::format("relative_error = {{ \"{}\" = {} }}", quantity, less) : "--error " + less,
      in_scene && finer <= scene::Scene::most_elements_times
          ? fmt::format("accuracy.elements_times = [{:g}, {:g}], which allows a finer mesh", finer / 2, finer)
          : fmt::format("make elements {:.2g} times shorter", shorter)));
}

}  // namespace ricochet::coupler
