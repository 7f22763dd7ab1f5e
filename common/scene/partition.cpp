#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/fem/element.hpp"
#include "common/scene/build.hpp"
#include "common/scene/protocols.hpp"
#include "common/scene/reader.hpp"

namespace ricochet::scene {
namespace {

/// Elements that lie within `length` of the contact surface, measured against its outward normal.
std::vector<bool> within_length(const BodyProblem& body, const Eigen::Vector2d& outward, int contact_node,
                                double length) {
  const Eigen::Vector2d surface = body.mesh.position[at(contact_node)];
  const auto corners = at(fem::nodes_per_element(body.section.model));
  std::vector<bool> inside;
  for (const auto& element : body.mesh.elements) {
    bool whole = true;
    for (std::size_t i = 0; i < corners; ++i) {
      const double depth = (surface - body.mesh.position[at(element[i])]).dot(outward);
      whole = whole && depth <= length * (1.0 + 1e-9);
    }
    inside.push_back(whole);
  }
  return inside;
}

std::vector<bool> in_groups(const Scene& scene, const BodyProblem& body) {
  std::vector<bool> inside(body.mesh.elements.size(), false);
  const auto groups = scene.partition.implicit_groups.find(body.name);
  if (groups == scene.partition.implicit_groups.end()) return inside;
  for (const std::string& group : groups->second) {
    const auto found = body.mesh.element_groups.find(group);
    if (found == body.mesh.element_groups.end()) {
      std::vector<std::string> known;
      for (const auto& entry : body.mesh.element_groups) known.push_back(entry.first);
      throw ConfigError(fmt::format("{}: found group \"{}\"{}; allowed: {}",
                                    scene.where("partition.implicit_groups." + body.name), group,
                                    did_you_mean(group, known), one_of(known)));
    }
    for (const int e : found->second) inside[at(e)] = true;
  }
  return inside;
}

/// Elements that the step is too long for, and the layer along the contact surface.
std::vector<bool> automatic(const BodyProblem& body, const std::vector<int>& contact, double step_s) {
  const auto corners = at(fem::nodes_per_element(body.section.model));
  std::vector<bool> inside;
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const auto& element = body.mesh.elements[at(e)];
    const bool touches = std::any_of(element.begin(), element.begin() + static_cast<std::ptrdiff_t>(corners),
                                     [&](int n) { return std::binary_search(contact.begin(), contact.end(), n); });
    const double frequency_squared = fem::element_max_frequency_squared(
        body.section, body.material, fem::element_coordinates(body.mesh, e));
    inside.push_back(touches || 2.0 / std::sqrt(frequency_squared) < step_s);
  }
  return inside;
}

std::vector<bool> implicit_elements(const Problem& problem, int index) {
  const Scene& scene = problem.scene;
  const BodyProblem& body = problem.bodies[at(index)];
  const Layout layout = protocol_traits(scene.coupling.protocol).layout;
  if (layout != Layout::hybrid) return std::vector<bool>(body.mesh.elements.size(), layout == Layout::all_implicit);
  const std::vector<int> contact = contact_nodes(problem.contact, index);
  switch (scene.partition.rule) {
    case PartitionRule::implicit_groups: return in_groups(scene, body);
    case PartitionRule::automatic: return automatic(body, contact, scene.time.step_s.value() / scene.coupling.substeps);
    case PartitionRule::implicit_length: break;
  }
  const auto length = scene.partition.implicit_length_m.find(body.name);
  if (length == scene.partition.implicit_length_m.end()) return std::vector<bool>(body.mesh.elements.size(), false);
  const Eigen::Vector2d& normal = problem.contact.normal;
  return within_length(body, index == problem.contact.body_a ? normal : -normal, contact.front(), length->second);
}

bool has(const std::vector<bool>& flags, bool value) {
  return std::find(flags.begin(), flags.end(), value) != flags.end();
}

/// An explicit and an implicit participant that have nothing to do are a misunderstanding.
void require_both_kinds(const Problem& problem) {
  bool any_explicit = false, any_implicit = false;
  for (const BodyProblem& body : problem.bodies) {
    any_explicit = any_explicit || has(body.implicit_element, false);
    any_implicit = any_implicit || has(body.implicit_node, true);
  }
  const std::string where = problem.scene.where("partition");
  if (!any_explicit)
    throw ConfigError(where + ": found every element implicit; allowed: some explicit elements, or protocol "
                              "\"all_implicit\"");
  if (!any_implicit)
    throw ConfigError(where + ": found nothing implicit; allowed: implicit elements or a contact, or protocol "
                              "\"all_explicit\"");
}

/// Each body's explicit elements belong to exactly one participant, and each participant has some.
void require_owners(const Problem& problem) {
  const Scene& scene = problem.scene;
  const auto has_explicit = [&](const std::string& name) {
    const auto body = std::find_if(problem.bodies.begin(), problem.bodies.end(),
                                   [&](const BodyProblem& b) { return b.name == name; });
    return has(body->implicit_element, false);
  };
  std::vector<std::string> owned;
  for (const ParticipantSpec& participant : scene.participants) {
    if (participant.role != Role::explicit_solver) continue;
    owned.insert(owned.end(), participant.bodies.begin(), participant.bodies.end());
    if (std::none_of(participant.bodies.begin(), participant.bodies.end(), has_explicit))
      throw ConfigError(scene.where("participant." + participant.name) +
                        ": found no explicit element in its bodies; allowed: a participant with elements, or a shorter "
                        "implicit part");
  }
  for (const BodyProblem& body : problem.bodies)
    if (has_explicit(body.name) && std::find(owned.begin(), owned.end(), body.name) == owned.end())
      throw ConfigError(scene.where("participant") + ": found no explicit participant for body \"" + body.name +
                        "\"; allowed: each body with explicit elements in one");
}

/// A dual protocol duplicates the shared nodes: either side needs mass of its own there, and the contact must leave their
/// velocity alone.
void require_own_nodes(const Problem& problem) {
  const Scene& scene = problem.scene;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const BodyProblem& body = problem.bodies[at(index)];
    const std::vector<bool> of_explicit = touched_nodes(body, false);
    for (const int node : contact_nodes(problem.contact, index))
      if (of_explicit[at(node)])
        throw ConfigError(fmt::format(
            "{}: found explicit elements at the contact of body \"{}\" (node {}); allowed with protocol \"{}\": a layer of "
            "implicit elements between, or protocol \"hughes_liu\"",
            scene.where("partition"), body.name, node, scene.coupling.protocol));
  }
}

}  // namespace

std::vector<bool> touched_nodes(const BodyProblem& body, bool implicit) {
  const auto corners = at(fem::nodes_per_element(body.section.model));
  std::vector<bool> touched(body.mesh.position.size(), false);
  for (std::size_t e = 0; e < body.mesh.elements.size(); ++e) {
    if (body.implicit_element[e] != implicit) continue;
    for (std::size_t i = 0; i < corners; ++i) touched[at(body.mesh.elements[e][i])] = true;
  }
  return touched;
}

void set_partition(Problem& problem) {
  const Layout layout = protocol_traits(problem.scene.coupling.protocol).layout;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    BodyProblem& body = problem.bodies[at(index)];
    body.implicit_element = implicit_elements(problem, index);
    body.implicit_node = touched_nodes(body, true);
    if (layout != Layout::hybrid) continue;
    for (const int node : contact_nodes(problem.contact, index)) body.implicit_node[at(node)] = true;
  }
  if (layout != Layout::hybrid) return;
  require_both_kinds(problem);
  require_owners(problem);
  if (protocol_traits(problem.scene.coupling.protocol).dual) require_own_nodes(problem);
}

}  // namespace ricochet::scene
