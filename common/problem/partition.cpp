#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/automatic_partition.hpp"
#include "common/problem/build.hpp"
#include "common/scene/protocols.hpp"
#include "common/scene/reader.hpp"

namespace ricochet::scene {
namespace {

/// Elements that lie within `length` of the contact surface, measured against its outward normal from where it is
/// farthest out.
std::vector<bool> within_length(const BodyProblem& body, const Eigen::Vector3d& outward,
                                const std::vector<int>& contact, double length) {
  Eigen::Vector3d surface = body.mesh.position[at(contact.front())];
  for (const int node : contact)
    if ((body.mesh.position[at(node)] - surface).dot(outward) > 0.0) surface = body.mesh.position[at(node)];
  std::vector<bool> inside;
  for (const auto& element : body.mesh.elements) {
    bool whole = true;
    for (const int node : element) {
      const double depth = (surface - body.mesh.position[at(node)]).dot(outward);
      whole = whole && depth <= length * (1.0 + 1e-9);
    }
    inside.push_back(whole);
  }
  return inside;
}

/// Elements of a body that belong to one of the groups; `key` of the scene names them.
std::vector<bool> in_groups(const Scene& scene, const BodyProblem& body, const std::vector<std::string>& groups,
                            const std::string& key) {
  std::vector<bool> inside(body.mesh.elements.size(), false);
  for (const std::string& group : groups) {
    const auto found = body.mesh.element_groups.find(group);
    if (found == body.mesh.element_groups.end()) {
      std::vector<std::string> known;
      for (const auto& entry : body.mesh.element_groups) known.push_back(entry.first);
      throw ConfigError(fmt::format("{}: found group \"{}\"{}; allowed: {}", scene.where(key), group,
                                    did_you_mean(group, known), one_of(known)));
    }
    for (const int e : found->second) inside[at(e)] = true;
  }
  return inside;
}

std::vector<bool> in_implicit_groups(const Scene& scene, const BodyProblem& body) {
  const auto groups = scene.partition.implicit_groups.find(body.name);
  if (groups == scene.partition.implicit_groups.end()) return std::vector<bool>(body.mesh.elements.size(), false);
  return in_groups(scene, body, groups->second, "partition.implicit_groups." + body.name);
}

/// Explicit elements have to bear every one. 0 where the step follows from what is explicit.
double longest_step_s(const Time& time) {
  double longest_s = time.step_s.value_or(0.0);
  if (time.flight_step_s) longest_s = std::max(longest_s, *time.flight_step_s);
  for (const StepChange& change : time.changes) longest_s = std::max(longest_s, change.step_s);
  return longest_s;
}

std::vector<bool> implicit_elements(const Problem& problem, int index) {
  const Scene& scene = problem.scene;
  const BodyProblem& body = problem.bodies[at(index)];
  const Layout layout = scene.coupling.protocol.layout;
  if (layout != Layout::hybrid) return std::vector<bool>(body.mesh.elements.size(), layout == Layout::all_implicit);
  const std::vector<int> contact = contact_nodes(problem.contacts, index);
  if (body.mesh.rigid_nodes > 0 && !contact.empty()) return std::vector<bool>(body.mesh.elements.size(), true);
  switch (scene.partition.rule) {
    case PartitionRule::implicit_groups: return in_implicit_groups(scene, body);
    case PartitionRule::automatic:
      if (scene.is_reduced(body.name)) return elements_at(body.mesh, contact);  // modes bear any step
      return automatic_elements(body, contact, automatic_step_s(scene, body.name));
    case PartitionRule::implicit_length: break;
  }
  const auto length = scene.partition.implicit_length_m.find(body.name);
  if (length == scene.partition.implicit_length_m.end()) return std::vector<bool>(body.mesh.elements.size(), false);
  std::vector<bool> inside(body.mesh.elements.size(), false);
  for (const ContactGeometry& geometry : problem.contacts) {
    const std::vector<int> nodes = contact_nodes(geometry, index);
    if (nodes.empty()) continue;
    const Eigen::Vector3d outward = index == geometry.body_a ? geometry.normal : Eigen::Vector3d(-geometry.normal);
    const std::vector<bool> near = within_length(body, outward, nodes, length->second);
    std::transform(inside.begin(), inside.end(), near.begin(), inside.begin(), std::logical_or<>());
  }
  if (!scene.massless_contact()) return inside;
  const std::vector<bool> layer =
      elements_at(body.mesh, contact);  // massless nodes are moved by the elements behind them
  std::transform(inside.begin(), inside.end(), layer.begin(), inside.begin(), std::logical_or<>());
  return inside;
}

bool has(const std::vector<bool>& flags, bool value) {
  return std::find(flags.begin(), flags.end(), value) != flags.end();
}

/// An explicit and an implicit participant that have nothing to do are a misunderstanding.
void require_both_kinds(const Problem& problem) {
  bool any_explicit = !problem.joints.empty(), any_implicit = false;
  for (const BodyProblem& body : problem.bodies) {
    any_explicit = any_explicit || has(body.implicit_element, false);
    any_implicit = any_implicit || has(body.implicit_node, true);
  }
  const std::string where = problem.scene.where("partition");
  if (!any_explicit)
    throw ConfigError(where +
                      ": found every element implicit; allowed: some explicit elements, or protocol "
                      "\"all_implicit\"");
  if (!any_implicit)
    throw ConfigError(where +
                      ": found nothing implicit; allowed: implicit elements or a contact, or protocol "
                      "\"all_explicit\"");
}

std::string place(const BodyProblem& body, int node) {
  return fmt::format("{} of body \"{}\"", fem::place_text(body.mesh.model, body.mesh.position[at(node)]), body.name);
}

/// Per element of a body the index of the explicit participant that owns it, -1 for implicit ones: each explicit
/// element belongs to exactly one.
std::vector<int> explicit_owners(const Scene& scene, const BodyProblem& body) {
  std::vector<int> owner(body.mesh.elements.size(), -1);
  for (std::size_t p = 0; p < scene.participants.size(); ++p) {
    if (scene.participants[p].role != Role::explicit_solver) continue;
    const std::vector<bool> own = owned_elements(scene, body, scene.participants[p]);
    for (std::size_t e = 0; e < own.size(); ++e) {
      if (!own[e]) continue;
      if (owner[e] >= 0)
        throw ConfigError(
            fmt::format("{}: found the element at {} in the groups of \"{}\", too; allowed: each element in one",
                        scene.where("participant." + scene.participants[p].name + ".groups"),
                        place(body, body.mesh.elements[e][0]), scene.participants[at(owner[e])].name));
      owner[e] = static_cast<int>(p);
    }
  }
  for (std::size_t e = 0; e < owner.size(); ++e)
    if (owner[e] < 0 && !body.implicit_element[e])
      throw ConfigError(
          fmt::format("{}: found no explicit participant for the element at {}; allowed: each explicit element in "
                      "one",
                      scene.where("participant"), place(body, body.mesh.elements[e][0])));
  return owner;
}

/// Only the implicit participant integrates what participants share: where two explicit ones meet, it must be there,
/// too.
void require_implicit_between(const Scene& scene, const BodyProblem& body, const std::vector<int>& owner) {
  std::vector<int> of_node(body.mesh.position.size(), -1);
  for (std::size_t e = 0; e < owner.size(); ++e) {
    if (owner[e] < 0) continue;
    fem::for_each_carrier(body.mesh, body.mesh.elements[e], [&](int node) {
      int& first = of_node[at(node)];
      if (first < 0) first = owner[e];
      if (first != owner[e] && !body.implicit_node[at(node)])
        throw ConfigError(fmt::format(
            "{}: found the node at {} shared by \"{}\" and \"{}\", which belongs to no implicit participant; make its "
            "elements implicit",
            scene.where("participant." + scene.participants[at(owner[e])].name), place(body, node),
            scene.participants[at(first)].name, scene.participants[at(owner[e])].name));
    });
  }
}

/// Each explicit element belongs to exactly one participant, and each participant has some.
void require_owners(const Problem& problem) {
  const Scene& scene = problem.scene;
  std::vector<bool> busy(scene.participants.size(), false);
  for (const BodyProblem& body : problem.bodies) {
    const std::vector<int> owner = explicit_owners(scene, body);
    require_implicit_between(scene, body, owner);
    for (const int p : owner)
      if (p >= 0) busy[at(p)] = true;
  }
  for (std::size_t p = 0; p < busy.size(); ++p)
    for (const std::string& body : scene.participants[p].bodies) busy[p] = busy[p] || scene.is_foreign(body);
  for (std::size_t p = 0; p < busy.size(); ++p)
    if (scene.participants[p].role == Role::explicit_solver && !busy[p])
      throw ConfigError(scene.where("participant." + scene.participants[p].name) +
                        ": found no explicit element in its bodies; allowed: a participant with elements, or a shorter "
                        "implicit part");
}

}  // namespace

double automatic_step_s(const Scene& scene, const std::string& body) {
  return longest_step_s(scene.time) / scene.substeps(body).fewest;
}

std::vector<bool> owned_elements(const Scene& scene, const BodyProblem& body, const ParticipantSpec& participant) {
  if (participant.role == Role::implicit_solver) return body.implicit_element;
  std::vector<bool> owned(body.mesh.elements.size(), false);
  if (std::find(participant.bodies.begin(), participant.bodies.end(), body.name) == participant.bodies.end())
    return owned;
  if (participant.groups.empty()) {
    owned.flip();
  } else {
    owned = in_groups(scene, body, participant.groups, "participant." + participant.name + ".groups");
  }
  for (std::size_t e = 0; e < owned.size(); ++e) owned[e] = owned[e] && !body.implicit_element[e];
  return owned;
}

std::vector<bool> elements_at(const fem::Mesh& mesh, const std::vector<int>& nodes) {
  std::vector<bool> at_them;
  for (const auto& element : mesh.elements) {
    bool is_there = false;
    fem::for_each_carrier(mesh, element,
                          [&](int n) { is_there = is_there || std::binary_search(nodes.begin(), nodes.end(), n); });
    at_them.push_back(is_there);
  }
  return at_them;
}

std::vector<bool> touched_nodes(const BodyProblem& body, const std::vector<bool>& of_element) {
  std::vector<bool> touched(body.mesh.position.size(), false);
  for (std::size_t e = 0; e < of_element.size(); ++e) {
    if (!of_element[e]) continue;
    fem::for_each_carrier(body.mesh, body.mesh.elements[e], [&](int node) { touched[at(node)] = true; });
  }
  return touched;
}

namespace {

std::vector<bool> touched_by_explicit(const BodyProblem& body) {
  std::vector<bool> is_explicit = body.implicit_element;
  is_explicit.flip();
  return touched_nodes(body, is_explicit);
}

/// Explicit elements at a contact node are in the way of a massless contact node, which follows its neighbours' forces
/// at once, and of a dual protocol, whose shared nodes' velocities the contact must leave alone.
void require_implicit_contact(const Problem& problem) {
  const Scene& scene = problem.scene;
  const bool massless = scene.massless_contact();
  const bool dual = scene.coupling.protocol.dual;
  if (!massless && !dual) return;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const BodyProblem& body = problem.bodies[at(index)];
    const std::vector<bool> touched = touched_by_explicit(body);
    for (const int node : contact_nodes(problem.contacts, index)) {
      if (!touched[at(node)] && !body.joined_node[at(node)]) continue;
      throw ConfigError(fmt::format(
          "{}: found \"{}\" and {} at the contact node at {}; allowed: implicit elements all around contact nodes{}",
          scene.where(massless ? "contact.multiplier_update" : "coupling.protocol"),
          massless ? "massless" : scene.coupling.protocol.name,
          touched[at(node)] ? "an explicit element" : "a foreign body", place(body, node),
          touched[at(node)] ? "" : ", where no foreign body is joined"));
    }
  }
}

/// Modes leave shared nodes no mass of theirs.
void require_mass_at_modes(const Problem& problem) {
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const BodyProblem& body = problem.bodies[at(index)];
    if (!problem.scene.is_reduced(body.name)) continue;
    const std::vector<bool> by_modes = touched_by_explicit(body), mass = touched_nodes(body, body.implicit_element);
    for (const int node : contact_nodes(problem.contacts, index))
      if (by_modes[at(node)] && !mass[at(node)])
        throw ConfigError(
            fmt::format("{}: found no implicit element at the contact node at {}; allowed: one at each, by a longer "
                        "partition.implicit_length_m or more implicit_groups",
                        problem.scene.where("partition.reduced_modes." + body.name), place(body, node)));
  }
}

/// Joined nodes are integrated by the implicit participant, which has mass of its own there whatever the protocol.
void add_joined_layer(BodyProblem& body) {
  for (std::size_t e = 0; e < body.implicit_element.size(); ++e) {
    bool joined = false;
    fem::for_each_carrier(body.mesh, body.mesh.elements[e],
                          [&](int node) { joined = joined || body.joined_node[at(node)]; });
    body.implicit_element[e] = body.implicit_element[e] || joined;
  }
}

}  // namespace

void set_partition(Problem& problem) {
  const Layout layout = problem.scene.coupling.protocol.layout;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    BodyProblem& body = problem.bodies[at(index)];
    body.implicit_element = implicit_elements(problem, index);
    if (body.mesh.rigid_nodes > 0 && has(body.implicit_element, true))  // as a whole
      body.implicit_element.assign(body.implicit_element.size(), true);
    if (layout == Layout::hybrid) add_joined_layer(body);
    if (layout == Layout::hybrid && problem.scene.partition.rule == PartitionRule::automatic)
      release_islands(problem, index);
    if (problem.scene.coupling.protocol.local_steps) body.small_steps.assign(body.mesh.elements.size(), true);
    body.implicit_node = touched_nodes(body, body.implicit_element);
    if (layout != Layout::hybrid) continue;
    for (const int node : contact_nodes(problem.contacts, index)) body.implicit_node[at(node)] = true;
  }
  if (layout != Layout::hybrid) return;
  require_both_kinds(problem);
  require_owners(problem);
  require_implicit_contact(problem);
  require_mass_at_modes(problem);
}

}  // namespace ricochet::scene
