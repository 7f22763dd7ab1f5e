#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "common/base/sha256.hpp"
#include "common/scene/loaders.hpp"
#include "common/scene/protocols.hpp"
#include "common/scene/toml_file.hpp"

namespace ricochet::scene {
namespace {

Model load_model(TableReader& root) {
  const std::vector<std::string> names(fem::model_names.begin(), fem::model_names.end());
  return static_cast<Model>(std::find(names.begin(), names.end(), root.word("model", names)) - names.begin());
}

void load_bodies(TableReader& root, Scene& scene) {
  const std::string folder = std::filesystem::path(scene.path).parent_path().string();
  if (!root.has("body")) root.missing("body", "one [[body]] table or more");
  std::vector<TableReader> foreign;  // read when what they may be joined to is known
  const auto require_new = [&](const TableReader& table, const std::string& name) {
    for (const std::string& other : scene.body_names())
      if (other == name) table.refuse("name", "\"" + name + "\" a second time", "a new name");
  };
  const std::map<std::string, Material> materials = load_materials(root, scene.model);
  for (TableReader& table : root.tables("body", "body")) {
    if (says_foreign(table)) {
      foreign.push_back(table);
      continue;
    }
    Body body = load_body(table, scene.model, folder, materials);
    require_new(table, body.name);
    scene.bodies.push_back(std::move(body));
  }
  for (TableReader& table : foreign) {
    ForeignBody body = load_foreign_body(table, scene);
    require_new(table, body.name);
    scene.foreign_bodies.push_back(std::move(body));
  }
}

/// Only with an automatic partition a step can be chosen by the cost.
void check_largest_step(const TableReader& time, Scene& scene) {
  const bool hybrid = scene.coupling.protocol.layout == Layout::hybrid;
  if (!hybrid) scene.time.largest_step_s.reset();  // nothing to choose
  if (hybrid && scene.partition.rule != PartitionRule::automatic && scene.time.largest_step_s)
    time.refuse("largest_step_s", "a largest step where the [partition] is given",
                "step_s, or partition.rule = \"auto\"");
}

/// They are found for a given step and given explicit elements.
void check_fewest_substeps(const Scene& scene) {
  if (!scene.coupling.fewest_substeps) return;
  const auto refuse = [&](const std::string& found, const std::string& allowed) {
    throw ConfigError(
        fmt::format("{}: found \"fewest\" {}; allowed: {}", scene.where("coupling.substeps"), found, allowed));
  };
  const std::string number = "a number of substeps, or \"fewest\" with ";
  if (!scene.coupling.protocol.own_substeps)
    refuse(fmt::format("under protocol \"{}\"", scene.coupling.protocol.name),
           number + "protocol = \"prakash_hjelmstad\"");
  if (!scene.time.step_s || scene.time.largest_step_s) refuse("without time.step_s", number + "step_s");
  if (scene.partition.rule == PartitionRule::automatic)
    refuse("with an automatic partition, which asks for the substeps first",
           number + "partition.implicit_length_m or implicit_groups");
}

/// Which protocol runs is known after the contact has been read.
void check_contact_keys(TableReader& root, const Scene& scene) {
  if (scene.contacts.empty() || scene.coupling.protocol.layout != Layout::all_explicit) return;
  const std::string needed = "an implicit side, which \"all_explicit\" has not";
  for (auto& contact : root.table_or_tables("contact", "contact")) {
    contact.only_if(false, "impact_update", needed);
    if (contact.has("multiplier_update") && scene.contact_law().multiplier_update == MultiplierUpdate::fully_implicit)
      contact.refuse("multiplier_update", "\"fully_implicit\" under \"all_explicit\"",
                     "\"trapezoidal_reset\" or \"massless\", or " + needed);
  }
}

/// Levels are found for one step, and contact inside small steps needs forces that close the gap at the end of it.
void check_local_steps(TableReader& root, const TableReader& time, const Scene& scene) {
  if (!scene.coupling.protocol.local_steps) return;
  if (!scene.time.step_s)
    root.refuse("time", "no step_s, which \"local_explicit\" needs: the step of the coarse elements",
                "step_s; elements that it is too long for take several steps in it");
  if (!scene.time.one_step())
    time.refuse(scene.time.key_of_sizes(), "steps of other sizes under \"local_explicit\"",
                "one step_s, or \"all_explicit\"");
  if (scene.contacts.empty()) return;
  const Contact& law = scene.contact_law();
  for (const auto& contact : root.table_or_tables("contact", "contact")) {
    if (law.enforcement == Enforcement::penalty)
      contact.refuse("enforcement", "\"penalty\" under \"local_explicit\"",
                     "\"multiplier\", whose force acts inside the small steps, or \"all_explicit\"");
    if (scene.massless_contact())
      contact.refuse("multiplier_update", "\"massless\" under \"local_explicit\"",
                     "\"trapezoidal_reset\", or \"all_explicit\"");
  }
}

/// The step that it allows is the run's, unless that is given.
void load_mass_scaling(TableReader& root, Scene& scene) {
  if (!root.has("mass_scaling")) return;
  const ProtocolTraits& protocol = scene.coupling.protocol;
  if (protocol.name != "all_explicit")
    root.refuse("mass_scaling", fmt::format("mass scaling under \"{}\"", protocol.name),
                "protocol = \"all_explicit\", which it is a variant of");
  TableReader table = root.table("mass_scaling", "mass_scaling");
  scene.mass_scaling_step_s = table.number("step_s", above(0.0));
  table.finish();
  if (!scene.time.step_s) scene.time.step_s = scene.mass_scaling_step_s;
}

/// A program of somebody else's has masses of its own.
void require_own_masses(const Scene& scene) {
  if (!scene.mass_scaling_step_s) return;
  for (const ParticipantSpec& participant : scene.participants)
    if (participant.foreign())
      throw ConfigError(fmt::format(
          "{}: found \"{}\" under [mass_scaling], which changes masses that this program has by itself; allowed: the "
          "shipped solver, or no [mass_scaling]",
          scene.where("participant." + participant.name + ".executable"), participant.executable));
}

void load_tables(TableReader& root, Scene& scene) {
  scene.model = load_model(root);
  load_bodies(root, scene);
  const bool several = root.is_array("contact");
  for (TableReader& table : root.table_or_tables("contact", "contact"))
    scene.contacts.push_back(load_contact(table, scene, several));
  if (root.has("partition")) {
    TableReader table = root.table("partition", "partition");
    scene.partition = load_partition(table, scene);
  }
  TableReader time = root.table("time", "time");
  scene.time = load_time(time, !scene.contacts.empty());
  if (root.has("coupling")) {
    TableReader table = root.table("coupling", "coupling");
    scene.coupling = load_coupling(table, !scene.contacts.empty());
  }
  load_mass_scaling(root, scene);
  check_contact_keys(root, scene);
  check_local_steps(root, time, scene);
  check_foreign_bodies(root, time, scene);
  check_largest_step(time, scene);
  check_fewest_substeps(scene);
  check_reduced_bodies(scene);
  std::vector<TableReader> participants = root.tables("participant", "participant");
  scene.participants = participants_of(scene, load_participants(participants, scene));
  require_own_masses(scene);
  require_foreign_owners(scene);
  if (root.has("output")) {
    TableReader table = root.table("output", "output");
    scene.output = load_output(table, scene);
  }
  if (root.has("checkpoint")) {
    TableReader table = root.table("checkpoint", "checkpoint");
    scene.checkpoint = load_checkpoint(table);
  }
  if (root.has("accuracy")) {
    TableReader table = root.table("accuracy", "accuracy");
    load_accuracy(table, scene);
  }
  root.finish();
}

/// Digest of everything the scene is made of.
std::string digest(const std::string& text, const Scene& scene) {
  std::string all = text;
  for (const Body& body : scene.bodies)
    for (const GmshMesh* file : body.files()) all += read_text(file->path);
  for (const ForeignBody& body : scene.foreign_bodies)
    for (const std::string& path : {body.interface_nodes, body.interface_faces})
      if (!path.empty()) all += read_text(path);
  return sha256_hex(all);
}

}  // namespace

Scene load_scene(const std::string& path) {
  if (!is_file(path)) throw ConfigError(path + ": no such scene file");
  Scene scene;
  scene.path = std::filesystem::absolute(path).lexically_normal().string();
  const std::string text = read_text(path);
  const Toml file = parse_toml(scene.path, text);
  if (file.as_table().empty())
    throw ConfigError(scene.path + ":1: the scene file is empty; allowed: model, [[body]], [time] and more");
  TableReader root(file, "scene", "", {scene.path, scene.lines});
  load_tables(root, scene);
  scene.sha256 = digest(text, scene);
  return scene;
}

}  // namespace ricochet::scene
