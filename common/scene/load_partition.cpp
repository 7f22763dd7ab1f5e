#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "common/base/names.hpp"
#include "common/scene/loaders.hpp"

namespace ricochet::scene {
namespace {

/// Bodies in contact that may be implicit in part.
std::vector<std::string> contact_bodies(const Scene& scene) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& body) {
    if (!scene.body(body).rigid && std::find(names.begin(), names.end(), body) == names.end()) names.push_back(body);
  };
  for (const Contact& contact : scene.contacts) {
    add(contact.first.body);
    if (contact.second) add(contact.second->body);
  }
  return names;
}

void load_implicit_length(TableReader& table, const Scene& scene, Partition& partition) {
  table.only_if(!scene.contacts.empty(), "implicit_length_m",
                "a [contact] table: the length is measured from the contact surface; use implicit_groups");
  const std::vector<std::string> bodies = contact_bodies(scene);
  partition.rule = PartitionRule::implicit_length;
  partition.implicit_length_m = table.numbers_by_name("implicit_length_m", at_least(0.0), bodies);
  for (const std::string& body : bodies)
    if (partition.implicit_length_m.count(body) == 0)
      table.refuse("implicit_length_m", "no length for body \"" + body + "\"",
                   "a length for each body in contact; 0 keeps only its contact nodes implicit");
}

void load_implicit_groups(TableReader& table, const Scene& scene, Partition& partition) {
  std::vector<std::string> bodies;
  for (const Body& body : scene.bodies) bodies.push_back(body.name);
  partition.rule = PartitionRule::implicit_groups;
  partition.implicit_groups = table.texts_by_name("implicit_groups", bodies);
  for (const auto& [body, groups] : partition.implicit_groups)
    if (scene.body(body).structured() != nullptr)
      table.refuse("implicit_groups", "groups of body \"" + body + "\", whose structured mesh has none",
                   "bodies of pieces or read from a mesh file; use implicit_length_m");
}

constexpr double most_modes = 10000;

void load_reduced_modes(TableReader& table, const Scene& scene, Partition& partition) {
  std::vector<std::string> bodies;
  for (const Body& body : scene.bodies) bodies.push_back(body.name);
  for (const auto& [body, modes] : table.numbers_by_name("reduced_modes", {1.0, most_modes, true, true}, bodies)) {
    if (modes != std::floor(modes))
      table.refuse("reduced_modes", fmt::format("{} for body \"{}\"", modes, body), "a whole number of modes");
    partition.reduced_modes[body] = static_cast<int>(modes);
  }
}

bool any(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double value) { return value != 0.0; });
}

/// A key of what is not in the modes of a linear body that nothing acts on but supports and the implicit side; "":
/// none.
std::string beyond_modes(const Body& body) {
  if (body.yields()) return "plasticity";
  if (body.rigid) return "rigid";
  if (body.large_rotation) return "large_rotation";
  if (any(body.gravity_m_s2)) return "gravity_m_s2";
  if (!body.tractions.empty()) return "traction";
  if (!body.prescribed.empty()) return "prescribed";
  if (!body.absorbing.empty()) return "absorbing";
  return any(body.initial_displacement_start_m) || any(body.initial_displacement_end_m) ? "initial_displacement_m" : "";
}

}  // namespace

Partition load_partition(TableReader& table, const Scene& scene) {
  Partition partition;
  const int rules = static_cast<int>(table.has("implicit_length_m")) + static_cast<int>(table.has("implicit_groups")) +
                    static_cast<int>(table.has("rule"));
  if (rules != 1)
    table.refuse("", fmt::format("{} of its keys", rules), "exactly one of implicit_length_m, implicit_groups, rule");
  if (table.has("implicit_length_m")) load_implicit_length(table, scene, partition);
  if (table.has("implicit_groups")) load_implicit_groups(table, scene, partition);
  partition.rule = table.choice<PartitionRule>("rule", {{"auto", PartitionRule::automatic}}, partition.rule);
  if (table.has("reduced_modes")) load_reduced_modes(table, scene, partition);
  table.finish();
  return partition;
}

void check_reduced_bodies(const Scene& scene) {
  if (scene.coupling.protocol.layout != Layout::hybrid) return;
  for (const auto& reduced : scene.partition.reduced_modes) {
    const std::string& body = reduced.first;
    const auto refuse = [&](const std::string& found, const std::string& allowed) {
      throw ConfigError(
          fmt::format("{}: found {}; allowed: {}", scene.where("partition.reduced_modes." + body), found, allowed));
    };
    if (!scene.coupling.protocol.massless_boundary)
      refuse(fmt::format("modes under protocol \"{}\", which wants masses of the explicit side at shared nodes",
                         scene.coupling.protocol.name),
             "coupling.protocol = \"belytschko_mullen\", \"fixed_point\" or a baseline");
    if (!scene.time.step_s || scene.time.largest_step_s)
      refuse("modes, which bear any step", "time.step_s, chosen for the accuracy of the modes and of the contact");
    if (const std::string key = beyond_modes(scene.body(body)); !key.empty())
      refuse(fmt::format("modes of a body with {}", key),
             fmt::format("bodies without it, which only supports and contacts act on, or no reduced_modes for \"{}\"",
                         body));
  }
}

}  // namespace ricochet::scene
