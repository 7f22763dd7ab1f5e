#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <variant>

#include "common/scene/loaders.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

/// The names of the bodies that the scene meshes.
std::vector<std::string> meshed_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const Body& body : scene.bodies) names.push_back(body.name);
  return names;
}

/// A name with a '/' is a file beside the scene; one without is looked up on PATH.
std::string resolve_executable(const std::string& given, const Scene& scene) {
  if (given.find('/') == std::string::npos) return given;
  return (std::filesystem::path(scene.path).parent_path() / given).lexically_normal().string();
}

/// Element groups of a participant's one body, of pieces or from a mesh file: a structured mesh has none.
std::vector<std::string> load_groups(TableReader& table, const std::vector<std::string>& bodies, const Scene& scene) {
  const bool has_groups =
      bodies.size() == 1 && !scene.is_foreign(bodies.front()) && scene.body(bodies.front()).structured() == nullptr;
  table.only_if(has_groups, "groups", "bodies = [one body], of pieces or read from a mesh file");
  return table.texts("groups");
}

/// All that stands in front of the program: another program and its arguments.
std::vector<std::string> load_launch(TableReader& table) {
  const auto words = table.texts("launch");
  const auto& program = words.front();
  if (program.find('/') != std::string::npos && program.front() != '/')
    table.refuse("launch", "the relative path \"" + program + "\"",
                 "a program of PATH, or its absolute path, and its arguments");
  return words;
}

/// All of its bodies or none: elements step by step and modes are different programs.
bool is_reduced(TableReader& table, const ParticipantSpec& participant, const Scene& scene) {
  const auto& bodies = participant.bodies;
  const auto reduced = std::find_if(bodies.begin(), bodies.end(), [&](const auto& b) { return scene.is_reduced(b); });
  if (reduced == bodies.end()) return false;
  const auto other = std::find_if(bodies.begin(), bodies.end(), [&](const auto& b) { return !scene.is_reduced(b); });
  if (other != bodies.end())
    table.refuse("bodies", fmt::format("\"{}\" with partition.reduced_modes and \"{}\" without", *reduced, *other),
                 "bodies with them in one participant, those without in another");
  const std::string needed = "bodies without partition.reduced_modes";
  for (const char* key : {"executable", "groups", "ranks", "substeps"}) table.only_if(false, key, needed);
  return true;
}

constexpr int most_threads = 1024;

ParticipantSpec load_participant(TableReader& table, const Scene& scene) {
  ParticipantSpec participant;
  participant.name = table.name("name");
  table.rename("participant." + participant.name);
  participant.role = table.named<Role>("role");
  const bool is_explicit = participant.role == Role::explicit_solver;
  table.only_if(is_explicit, "bodies", "role = \"explicit\": the implicit participant owns all implicit elements");
  if (is_explicit) participant.bodies = table.words("bodies", scene.body_names());
  participant.reduced = is_reduced(table, participant, scene);
  table.only_if(is_explicit, "groups", "role = \"explicit\": the implicit participant owns all implicit elements");
  if (table.has("groups")) participant.groups = load_groups(table, participant.bodies, scene);
  if (table.has("executable")) participant.executable = resolve_executable(table.text("executable"), scene);
  for (const std::string& body : participant.bodies)
    if (scene.is_foreign(body) && !participant.foreign())
      table.refuse("bodies", "\"" + body + "\", which is foreign: no solver of ours has elements of it",
                   "\"" + body + "\" with the key executable, the program that computes it");
  participant.start =
      table.choice<Start>("start", {{"launch", Start::launch}, {"by_hand", Start::by_hand}}, Start::launch);
  table.only_if(participant.start == Start::launch, "launch", "start = \"launch\"");
  table.only_if(participant.foreign(), "differing_bodies", "executable, a program of your own");
  if (table.has("differing_bodies"))
    participant.differing_bodies =
        table.words("differing_bodies", is_explicit ? participant.bodies : meshed_names(scene));
  for (const std::string& body : participant.differing_bodies)
    if (scene.is_foreign(body))
      table.refuse("differing_bodies", "\"" + body + "\", which is foreign",
                   "bodies that the scene meshes: of a "
                   "foreign one there is nothing to differ from");
  if (table.has("launch")) participant.launch = load_launch(table);
  table.only_if(is_explicit && participant.start == Start::launch && participant.executable.empty(), "ranks",
                "role = \"explicit\", the shipped solver and start = \"launch\"");
  if (table.has("ranks")) participant.ranks = table.integer("ranks", 1, 100000);
  table.only_if(participant.executable.empty(), "threads",
                "the shipped solver: a program of your own (key executable) has its own ways");
  if (table.has("threads")) participant.threads = table.integer("threads", 1, most_threads);
  table.only_if(is_explicit && scene.coupling.protocol.own_substeps, "substeps",
                "role = \"explicit\" and protocol = \"prakash_hjelmstad\"");
  participant.substeps = scene.coupling.fewest_substeps && is_explicit ? 0 : scene.coupling.substeps;
  if (table.has("substeps")) participant.substeps = table.integer("substeps", 1, most_substeps);
  table.finish();
  return participant;
}

/// The first entry of a role, or the shipped solver of that name.
ParticipantSpec first_of(const std::vector<ParticipantSpec>& given, Role role) {
  for (const ParticipantSpec& participant : given)
    if (participant.role == role) return participant;
  ParticipantSpec shipped;
  shipped.name = name_of(role);
  shipped.role = role;
  return shipped;
}

}  // namespace

std::vector<ParticipantSpec> load_participants(std::vector<TableReader>& tables, const Scene& scene) {
  std::vector<ParticipantSpec> participants;
  std::map<std::string, ParticipantSpec> owner;  // body -> its first explicit participant
  for (TableReader& table : tables) {
    const ParticipantSpec participant = load_participant(table, scene);
    const bool implicit = participant.role == Role::implicit_solver;
    for (const ParticipantSpec& other : participants) {
      if (other.name == participant.name) table.refuse("name", "\"" + other.name + "\" a second time", "a new name");
      if (implicit && other.role == participant.role)
        table.refuse("role", "a second implicit participant", "one implicit participant: \"" + other.name + "\"");
    }
    for (const std::string& body : participant.bodies) {
      const auto [entry, first] = owner.emplace(body, participant);
      if (!first && (participant.groups.empty() || entry->second.groups.empty()))
        table.refuse("bodies", fmt::format("\"{}\", which \"{}\" has already", body, entry->second.name),
                     "each body in one explicit participant, or its element groups (key groups) in several");
    }
    participants.push_back(participant);
  }
  const bool hybrid = scene.coupling.protocol.layout == Layout::hybrid;
  const auto is_implicit = [](const ParticipantSpec& p) { return p.role == Role::implicit_solver; };
  if (hybrid && !tables.empty() && std::none_of(participants.begin(), participants.end(), is_implicit))
    tables.back().refuse("role", "no implicit participant", "one [[participant]] with role = \"implicit\"");
  return participants;
}

void require_foreign_owners(const Scene& scene) {
  for (const ForeignBody& body : scene.foreign_bodies) {
    const bool owned = std::any_of(scene.participants.begin(), scene.participants.end(), [&](const auto& participant) {
      return std::find(participant.bodies.begin(), participant.bodies.end(), body.name) != participant.bodies.end();
    });
    if (owned) continue;
    throw ConfigError(fmt::format(
        "{}: found no participant that computes the foreign body; allowed: a [[participant]] with role = \"explicit\", "
        "bodies = [\"{}\"] and executable, its program",
        scene.where("body." + body.name), body.name));
  }
}

std::vector<ParticipantSpec> participants_of(const Scene& scene, const std::vector<ParticipantSpec>& given) {
  const Layout layout = scene.coupling.protocol.layout;
  if (layout == Layout::hybrid && !given.empty()) return given;
  ParticipantSpec all_explicit = first_of(given, Role::explicit_solver);
  all_explicit.name = name_of(Role::explicit_solver);
  all_explicit.bodies = meshed_names(scene);
  all_explicit.groups.clear();
  if (given.empty()) all_explicit.substeps = scene.coupling.fewest_substeps ? 0 : scene.coupling.substeps;
  const ParticipantSpec implicit = first_of(given, Role::implicit_solver);
  if (layout == Layout::all_explicit) return {all_explicit};
  if (layout == Layout::all_implicit) return {implicit};
  ParticipantSpec reduced = all_explicit;
  reduced.name = "reduced";
  reduced.reduced = true;
  const auto of = [&](bool are_reduced) {
    auto bodies = meshed_names(scene);
    bodies.erase(
        std::remove_if(bodies.begin(), bodies.end(), [&](const auto& b) { return scene.is_reduced(b) != are_reduced; }),
        bodies.end());
    return bodies;
  };
  std::vector<ParticipantSpec> participants;
  for (ParticipantSpec& participant : std::array{all_explicit, reduced}) {
    participant.bodies = of(participant.reduced);
    if (!participant.bodies.empty()) participants.push_back(participant);
  }
  participants.push_back(implicit);
  return participants;
}

}  // namespace ricochet::scene
