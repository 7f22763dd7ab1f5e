#include "tests/bench/rounded_striker_rows.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "common/scene/variant.hpp"
#include "tests/support/places.hpp"

namespace ricochet::bench {
namespace {

struct Setting {
  std::string method, protocol;
  int substeps;
  double window_s, history_every;
};

/// From `ricochet study configs/studies/rounded_striker.toml` and `rounded_striker_substeps.toml`. Explicit steps of
/// both hybrids are 40 ns. Rows of the history are 40 ns apart or a window.
const std::vector<Setting> settings = {{"all_explicit", "all_explicit", 1, 1.7e-9, 24},
                                       {"all_implicit", "all_implicit", 1, 9.6e-7, 1},
                                       {"hughes_liu", "hughes_liu", 1, 4e-8, 1},
                                       {"prakash_hjelmstad, m = 16", "prakash_hjelmstad", 16, 6.4e-7, 1}};
const Setting reference = {"reference", "all_explicit", 1, 8.5e-10, 48};

SceneRun run_setting(const Setting& setting, const std::string& folder) {
  std::vector<scene::Override> overrides = {{"time.step_s", setting.window_s},
                                            {"coupling.protocol", setting.protocol},
                                            {"output.history_every", setting.history_every},
                                            {"output.fields_every", 0.0}};
  if (setting.substeps > 1) overrides.push_back({"coupling.substeps", static_cast<double>(setting.substeps)});
  const std::string scene = folder + "/rounded_striker.toml";
  scene::write_variant(test::source_folder() + "/configs/rounded_striker.toml", overrides, scene);
  return run_scene(scene, setting.substeps, folder + "/run");
}

}  // namespace

RoundedStriker::RoundedStriker(std::string folder)
    : folder_(std::move(folder)), reference_peak_n_(run_setting(reference, folder_).peak_force_n) {}

void RoundedStriker::repeat() {
  for (const Setting& setting : settings) runs_[setting.method].push_back(run_setting(setting, folder_));
}

std::vector<Row> RoundedStriker::rows() const {
  const std::string at = "18 um", best = "prakash_hjelmstad, m = 16";
  const auto each = [this](const std::string& method, auto value) {
    std::vector<double> values;
    for (const SceneRun& run : runs_.at(method)) values.push_back(value(run));
    return values;
  };
  std::vector<Row> rows;
  const auto compare = [&](const std::string& hybrid, const std::string& other, const char* what, auto value,
                           std::optional<Level> level) {
    rows.push_back({fmt::format("rounded striker: {} / {}, {}", hybrid, other, what), at,
                    quotients(each(hybrid, value), each(other, value)), level});
  };
  for (const std::string& hybrid : {best, std::string("hughes_liu")}) {
    for (const std::string other : {"all_explicit", "all_implicit"}) {
      const bool wanted = hybrid == best && other == "all_explicit";
      compare(
          hybrid, other, "whole run", [](const SceneRun& run) { return run.wall_s; },
          wanted ? std::optional(Level{true, 0.12}) : std::nullopt);
      compare(hybrid, other, "stepping", [](const SceneRun& run) { return run.stepping_s; }, {});
      compare(hybrid, other, "processor time", [](const SceneRun& run) { return run.usage.cpu_s; }, {});
    }
  }
  for (const Setting& setting : settings) {
    const auto error = [this](const SceneRun& run) { return std::abs(run.peak_force_n / reference_peak_n_ - 1.0); };
    rows.push_back({fmt::format("rounded striker, {}: error of the peak force", setting.method), at,
                    each(setting.method, error), Level{true, 0.005}});
  }
  return rows;
}

}  // namespace ricochet::bench
