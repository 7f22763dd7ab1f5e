#include "coupler/study/error_estimate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "coupler/report/run_page/summary_page.hpp"
#include "coupler/study/companions.hpp"
#include "coupler/study/error_bar.hpp"

namespace ricochet::coupler {
namespace {

using report::Json;
using scene::Override;

std::vector<Override> other_law(const scene::Scene& scene) {
  std::vector<Override> changes;
  const bool massless = scene.massless_contact();
  for (const auto& contact : scene.contacts)
    changes.push_back({contact.key() + ".multiplier_update", std::string(massless ? "trapezoidal_reset" : "massless")});
  return changes;
}

/// The companions say this of each quantity, whichever of them there are.
struct Estimate {
  Companions companions;
  std::map<std::string, QuantityLevels> levels;

  void take(const Companion& from, std::optional<double> QuantityLevels::*level,
            const std::vector<std::string>& parts) {
    for (auto& [name, of] : levels) {
      of.*level = from.value(name);
      if (of.*level) continue;
      const std::string reason = from.error.empty() ? "not a result of: " + from.what : from.what + ": " + from.error;
      for (const auto& part : parts) of.missing.emplace(part, reason);
    }
  }
  void unknown(const std::vector<std::string>& parts, const std::string& reason) {
    for (auto& [name, of] : levels)
      for (const auto& part : parts) of.missing.emplace(part, reason);
  }
};

/// On the level 2h: what other methods make of it.
void compare_methods(const scene::Scene& scene, const std::vector<Override>& coarse, Estimate& estimate) {
  auto& runs = estimate.companions;
  if (scene.coupling.protocol.layout == scene::Layout::hybrid) {
    const auto baseline = with(coarse, {{"coupling.protocol", std::string("all_implicit")}});
    estimate.take(runs.compute("elements and step doubled, all_implicit", baseline), &QuantityLevels::coarse_baseline,
                  {"coupling"});
  }
  if (!scene.contacts.empty() && scene.contact_law().enforcement == scene::Enforcement::multiplier) {
    estimate.take(runs.compute("elements and step doubled, other contact law", with(coarse, other_law(scene))),
                  &QuantityLevels::coarse_law, {"contact_law"});
  } else {
    estimate.unknown({"contact_law"}, "no contact, or a penalty, beside which there is no second law");
  }
}

/// False if the first companion fails, as where an element cannot be twice as wide.
bool estimate_by_meshes(const scene::Scene& scene, double step_s, Estimate& estimate) {
  const auto coarse = *with_elements(scene, 0.5);
  const auto both = with(coarse, {{"time.step_s", 2.0 * step_s}});
  auto& runs = estimate.companions;
  const auto first = runs.compute("elements and step doubled", both);
  estimate.take(first, &QuantityLevels::coarse, {"total", "space", "coupling", "contact_law"});
  if (!first.error.empty()) return false;
  estimate.take(runs.compute("elements and step four times as long",
                             with(*with_elements(scene, 0.25), {{"time.step_s", 4.0 * step_s}})),
                &QuantityLevels::coarsest, {"total", "time", "space", "coupling", "contact_law"});
  estimate.take(runs.compute("elements doubled", with(coarse, {{"time.step_s", step_s}})), &QuantityLevels::coarse_mesh,
                {"time", "space"});
  compare_methods(scene, both, estimate);
  return true;
}

/// Twice the step costs half as much; where it is refused or unstable, half of it.
void estimate_by_steps(double step_s, Estimate& estimate) {
  estimate.unknown({"total", "space"}, "a Gmsh mesh has no coarser one");
  estimate.unknown({"coupling", "contact_law"}, "on a Gmsh mesh the companion would cost as much as the run");
  auto& runs = estimate.companions;
  const auto longer = runs.compute("step doubled", {{"time.step_s", 2.0 * step_s}});
  if (longer.error.empty()) {
    estimate.take(longer, &QuantityLevels::double_step, {"time"});
  } else {
    estimate.take(runs.compute("step halved", {{"time.step_s", 0.5 * step_s}}), &QuantityLevels::half_step, {"time"});
  }
}

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(double value, const ErrorBar& bar) {
  return {{"value", value},
          {"total", json_of(bar.total)},
          {"time", json_of(bar.time)},
          {"space", json_of(bar.space)},
          {"coupling", json_of(bar.coupling)},
          {"contact_law", json_of(bar.contact_law)},
          {"order", json_of(bar.order)},
          {"found", bar.found},
          {"unknown", bar.unknown}};
}

std::string line_of(const std::string& name, double value, const ErrorBar& bar) {
  const auto text = [](const std::optional<double>& x) { return x ? fmt::format("{:.2g}", *x) : "unknown"; };
  return fmt::format("  {:<32} {:.5g} ± {:<8} time {}, space {}, coupling {}, contact law {}; {}\n", name, value,
                     text(bar.total), text(bar.time), text(bar.space), text(bar.coupling), text(bar.contact_law),
                     bar.order ? fmt::format("order {:.2g}", *bar.order) : bar.found);
}

/// The run's own values, before any companion.
std::map<std::string, QuantityLevels> levels_of(const std::string& folder, const scene::Scene& scene, double step_s) {
  std::map<std::string, QuantityLevels> all;
  for (const auto& [name, value] : values_of(folder, scene)) {
    auto& levels = all[name];
    levels.run = value;
    levels.hybrid = scene.coupling.protocol.layout == scene::Layout::hybrid;
    levels.floor = floor_of(name, step_s);
  }
  return all;
}

Json block_of(const std::vector<Companion>& companions) {
  Json block{{"wall_s", 0.0}, {"companions", Json::array()}, {"quantities", Json::object()}};
  double wall_s = 0.0;
  for (const auto& run : companions) {
    block["companions"].push_back({{"what", run.what}, {"wall_s", run.wall_s}, {"error", run.error}});
    wall_s += run.wall_s;
  }
  block["wall_s"] = wall_s;
  return block;
}

/// Whether the run has what its scene asks for; the entry of the quantity gets "asked" and "reached".
std::string verdict_of(const std::string& name, double asked, const std::map<std::string, double>& expected,
                       Json& quantities) {
  const std::string wanted = fmt::format("  asked: {} within {:g} %", name, 100.0 * asked);
  const auto found = quantities.find(name);
  if (found == quantities.end()) return wanted + ": not a result of this run\n";
  auto& entry = found.value();
  const auto bar = report::number(entry, "total");
  const double value = std::abs(entry.at("value").get<double>());
  const double share = bar && value > 0.0 ? *bar / value : 0.0;
  const bool reached = bar && value > 0.0 && share <= asked;
  entry["asked"] = asked;
  entry["reached"] = reached;
  if (!bar) return wanted + ": its bar is unknown\n";
  if (value == 0.0) return wanted + ": not reached, its value of 0 has no relative error\n";
  const std::string bar_is = fmt::format("its bar is {:.2g} %\n", 100.0 * share);
  if (reached) return fmt::format("{}: reached, {}", wanted, bar_is);
  const auto before = expected.find(name);
  if (before == expected.end()) return fmt::format("{}: not reached, {}", wanted, bar_is);
  return fmt::format(
      "{}: not reached, {}    {:.2g} % were expected: with relative_error = {{ \"{}\" = {:.2g} }} another may be "
      "chosen\n",
      wanted, bar_is, 100.0 * before->second, name, asked * before->second / share);
}

}  // namespace

std::string estimate_error(const scene::Scene& scene, double step_s, const ResultsDirectory& results,
                           const std::map<std::string, double>& expected) {
  Estimate estimate{{scene, results.file("accuracy")}, levels_of(results.path(), scene, step_s)};
  if (!with_elements(scene, 0.5) || !estimate_by_meshes(scene, step_s, estimate)) estimate_by_steps(step_s, estimate);
  Json block = block_of(estimate.companions.all());
  std::string text;
  std::set<std::string> reasons;
  for (const auto& [name, levels] : estimate.levels) {
    const auto bar = error_bar(levels);
    block["quantities"][name] = json_of(levels.run, bar);
    text += line_of(name, levels.run, bar);
    for (const auto& [part, reason] : bar.unknown) reasons.insert(part + " unknown: " + reason);
  }
  for (const auto& reason : reasons) text += "  " + reason + "\n";
  for (const auto& [name, asked] : scene.accuracy) text += verdict_of(name, asked, expected, block["quantities"]);
  Json summary = report::read_summary(results.file("summary.json"));
  const std::string title =
      fmt::format("error bars from {} companion runs, {:.3f} s (this run: {:.3f} s), kept in {}\n",
                  estimate.companions.all().size(), block.at("wall_s").get<double>(),
                  report::number(summary, "wall_s").value_or(0.0), results.file("accuracy"));
  summary["error_bar"] = std::move(block);
  write_atomically(results.file("summary.json"), summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  return title + text;
}

}  // namespace ricochet::coupler
