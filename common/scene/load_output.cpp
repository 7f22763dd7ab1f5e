#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/base/names.hpp"
#include "common/scene/loaders.hpp"

/// The output of a run: how often, and of which places.
namespace ricochet::scene {
namespace {

constexpr int most_windows = std::numeric_limits<int>::max();

/// A number of windows, or in its place the time between two rows.
void load_every(TableReader& table, const std::string& key, const Scene& scene, int least, int& every,
                std::optional<double>& every_s) {
  const std::string key_s = key + "_s";
  if (table.has(key) && table.has(key_s)) table.refuse(key_s, fmt::format("both {} and {}", key, key_s), "one of them");
  every = table.integer(key, least, most_windows, every);
  table.only_if(
      scene.time.one_step(), key_s,
      fmt::format("windows of one size; with time.{} give {}, a number of windows", scene.time.key_of_sizes(), key));
  if (table.has(key_s)) every_s = table.number(key_s, above(0.0));
}

/// A name that no probe and no gauge before has: it begins the names of columns.
std::string load_place_name(TableReader& table, const Output& output, const char* kind) {
  const std::string name = table.name("name");
  const auto taken = [&](const auto& other) { return other.name == name; };
  if (std::any_of(output.probes.begin(), output.probes.end(), taken) ||
      std::any_of(output.gauges.begin(), output.gauges.end(), taken))
    table.refuse("name", "\"" + name + "\" a second time", "a name that no other probe or gauge has");
  table.rename(fmt::format("output.{}.{}", kind, name));
  return name;
}

std::string load_place_body(TableReader& table, const Scene& scene) {
  std::vector<std::string> bodies;
  for (const Body& body : scene.bodies) bodies.push_back(body.name);
  return table.word("body", bodies);
}

Probe load_probe(TableReader& table, const Scene& scene, const Output& output) {
  Probe probe;
  probe.name = load_place_name(table, output, "probe");
  probe.body = load_place_body(table, scene);
  probe.at_m = table.numbers("at_m", any_number(), static_cast<std::size_t>(scene.components()));
  table.finish();
  return probe;
}

Gauge load_gauge(TableReader& table, const Scene& scene, const Output& output) {
  Gauge gauge;
  gauge.name = load_place_name(table, output, "gauge");
  gauge.body = load_place_body(table, scene);
  gauge.section_m = table.number("section_m", any_number());
  gauge.length_m = table.number("length_m", at_least(0.0), gauge.length_m);
  table.only_if(scene.model != Model::bar, "surface", "a model of two or three dimensions: a bar has no sides");
  if (table.has("surface")) {
    gauge.surface = table.text("surface");
    const std::vector<std::string> surfaces = surface_names(scene.model, scene.body(gauge.body));
    if (!surfaces.empty() && std::find(surfaces.begin(), surfaces.end(), gauge.surface) == surfaces.end())
      table.refuse("surface", "\"" + gauge.surface + "\"" + did_you_mean(gauge.surface, surfaces), one_of(surfaces));
  }
  gauge.rise_time_s = table.number("rise_time_s", at_least(0.0), gauge.rise_time_s);
  table.finish();
  return gauge;
}

}  // namespace

Output load_output(TableReader& table, const Scene& scene) {
  Output output;
  load_every(table, "history_every", scene, 1, output.history_every, output.history_every_s);
  load_every(table, "fields_every", scene, 0, output.fields_every, output.fields_every_s);
  output.axial_stress_every = table.integer("axial_stress_every", 0, most_windows, output.axial_stress_every);
  for (TableReader& probe : table.tables("probe", "probe")) output.probes.push_back(load_probe(probe, scene, output));
  for (TableReader& gauge : table.tables("gauge", "gauge")) output.gauges.push_back(load_gauge(gauge, scene, output));
  const bool places = !output.probes.empty() || !output.gauges.empty();
  load_every(table, "probes_every", scene, 0, output.probes_every, output.probes_every_s);
  table.only_if(places, "probes_every_s", "an [[output.probe]] or an [[output.gauge]]");
  table.finish();
  return output;
}

}  // namespace ricochet::scene
