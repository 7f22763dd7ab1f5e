#include "common/problem/automatic_partition.hpp"

#include <algorithm>
#include <numeric>

#include "common/fem/element_copies.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

/// A share of the critical step: closer to it `check` warns that waves may grow from impact to impact.
constexpr double quiet_share_squared = 0.95 * 0.95;

/// Those whose own frequency squared is above `limit`, but for those inside.
std::vector<bool> stiff_elements(const BodyProblem& body, const std::vector<bool>& inside, double limit) {
  std::vector<bool> stiff(inside.size(), false);
  fem::ElementCopies<bool> above(body.section.model);
  for (int e = 0; e < static_cast<int>(stiff.size()); ++e) {
    if (inside[at(e)]) continue;
    const auto make = [&](const fem::ElementGeometry& geometry) {
      return fem::element_frequency_squared_above(body.section, fem::material_of(body, e), geometry, limit);
    };
    stiff[at(e)] = above.of(fem::element_geometry(body.mesh, e), make, fem::material_index(body.mesh, e));
  }
  return stiff;
}

/// Per node of stiff elements: the mean, by mass, of what elements that are not inside have is above `limit`. All nodes
/// that carry a stiff element with a hanging node, all among stiff elements alone, and all where masses are scaled.
std::vector<bool> too_stiff_nodes(const BodyProblem& body, const std::vector<bool>& inside,
                                  const std::vector<bool>& stiff, double limit) {
  const std::size_t nodes = body.mesh.position.size();
  std::vector<bool> too_stiff(nodes, false), of_stiff(nodes, false), of_others(nodes, false);
  for (std::size_t e = 0; e < stiff.size(); ++e) {
    bool at_once = stiff[e] && !body.density_factor.empty();
    for (const int node : body.mesh.elements[e]) {
      if (!inside[e]) (stiff[e] ? of_stiff : of_others)[at(node)] = true;
      at_once = at_once || (stiff[e] && fem::hanging_at(body.mesh, node) != nullptr);
    }
    if (at_once) fem::for_each_carrier(body.mesh, body.mesh.elements[e], [&](int node) { too_stiff[at(node)] = true; });
  }
  std::vector<bool> open(nodes);
  for (std::size_t n = 0; n < nodes; ++n) {
    too_stiff[n] = too_stiff[n] || (of_stiff[n] && !of_others[n]);
    open[n] = of_stiff[n] && !too_stiff[n];
  }
  std::vector<double> mass(nodes, 0.0), sum(nodes, 0.0);
  for (int e = 0; e < static_cast<int>(stiff.size()); ++e) {
    const fem::Element& element = body.mesh.elements[at(e)];
    if (inside[at(e)] || std::none_of(element.begin(), element.end(), [&](int node) { return open[at(node)]; }))
      continue;
    const fem::Material& material = fem::material_of(body, e);
    const fem::ElementGeometry geometry = fem::element_geometry(body.mesh, e);
    const double frequency_squared = fem::element_max_frequency_squared(body.section, material, geometry);
    const Eigen::VectorXd own = fem::element_lumped_mass(body.section, material, geometry);
    for (std::size_t i = 0; i < element.size(); ++i) {
      mass[at(element[i])] += own[static_cast<Eigen::Index>(i)];
      sum[at(element[i])] += own[static_cast<Eigen::Index>(i)] * frequency_squared;
    }
  }
  for (std::size_t n = 0; n < nodes; ++n) too_stiff[n] = too_stiff[n] || (open[n] && sum[n] > limit * mass[n]);
  return too_stiff;
}

/// Per node one that stands for all those which implicit elements join.
std::vector<int> joined_by_implicit(const BodyProblem& body) {
  std::vector<int> parent(body.mesh.position.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int node) {
    while (parent[at(node)] != node) node = parent[at(node)] = parent[at(parent[at(node)])];
    return node;
  };
  for (std::size_t e = 0; e < body.implicit_element.size(); ++e) {
    if (!body.implicit_element[e]) continue;
    const int first = root(body.mesh.elements[e][0]);
    for (const int node : body.mesh.elements[e]) parent[at(root(node))] = first;
    fem::for_each_carrier(body.mesh, body.mesh.elements[e], [&](int node) { parent[at(root(node))] = first; });
  }
  for (int node = 0; node < static_cast<int>(parent.size()); ++node) parent[at(node)] = root(node);
  return parent;
}

/// Take small steps in a body.
bool explicit_side_can(const Scene& scene, const std::string& body) {
  const ProtocolTraits& protocol = scene.coupling.protocol;
  const auto ours = [&](const ParticipantSpec& participant) {
    const bool has_it =
        std::find(participant.bodies.begin(), participant.bodies.end(), body) != participant.bodies.end();
    return participant.role != Role::explicit_solver || !has_it ||
           (!participant.foreign() && !participant.reduced && participant.groups.empty() &&
            (participant.ranks.value_or(1) == 1 || !scene.body(body).large_rotation));
  };
  return protocol.layout == Layout::hybrid && !protocol.dual && scene.substeps(body).most == 1 &&
         scene.time.one_step() && std::all_of(scene.participants.begin(), scene.participants.end(), ours);
}

/// Few, or not much too stiff for the window: none is as fine as what is better off implicit.
bool better_off_explicit(const BodyProblem& body, const std::vector<int>& elements, double window_s) {
  const double limit = 4.0 * finest_explicit * finest_explicit / (window_s * window_s);
  return elements.size() < sliver_elements || std::none_of(elements.begin(), elements.end(), [&](int e) {
           return fem::element_frequency_squared_above(body.section, fem::material_of(body, e),
                                                       fem::element_geometry(body.mesh, e), limit);
         });
}

bool has_dashpot(const BodyProblem& body, const std::vector<int>& elements) {
  const int components = fem::components(body.section.model);
  bool any = false;
  for (const int e : elements)
    fem::for_each_carrier(body.mesh, body.mesh.elements[at(e)], [&](int node) {
      any = any || !body.damping_kg_s.segment(node * components, components).isZero(0.0);
    });
  return any;
}

}  // namespace

std::vector<bool> automatic_elements(const BodyProblem& body, const std::vector<int>& contact, double step_s) {
  std::vector<bool> inside = elements_at(body.mesh, contact);
  if (body.mesh.rigid_nodes > 0) return inside;
  const std::vector<bool> stiff = stiff_elements(body, inside, 4.0 / (step_s * step_s));
  const std::vector<bool> too_stiff =
      too_stiff_nodes(body, inside, stiff, quiet_share_squared * 4.0 / (step_s * step_s));
  for (std::size_t e = 0; e < inside.size(); ++e) {
    if (!stiff[e]) continue;
    fem::for_each_carrier(body.mesh, body.mesh.elements[e],
                          [&](int node) { inside[e] = inside[e] || too_stiff[at(node)]; });
  }
  return inside;
}

std::vector<std::vector<int>> elements_of_islands(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  const std::vector<int> joined = joined_by_implicit(body);
  std::vector<bool> held(joined.size(), false);
  for (const int node : contact_nodes(problem.contacts, index)) held[at(joined[at(node)])] = true;
  for (std::size_t n = 0; n < body.joined_node.size(); ++n)
    if (body.joined_node[n]) held[at(joined[n])] = true;
  std::vector<std::vector<int>> islands;
  std::vector<int> island_of(joined.size(), -1);
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const int root = joined[at(body.mesh.elements[at(e)][0])];
    if (!body.implicit_element[at(e)] || held[at(root)]) continue;
    if (island_of[at(root)] < 0) {
      island_of[at(root)] = static_cast<int>(islands.size());
      islands.emplace_back();
    }
    islands[at(island_of[at(root)])].push_back(e);
  }
  return islands;
}

void release_islands(Problem& problem, int index) {
  BodyProblem& body = problem.bodies[at(index)];
  if (problem.contacts.empty() || !explicit_side_can(problem.scene, body.name)) return;
  for (const std::vector<int>& elements : elements_of_islands(problem, index)) {
    if (has_dashpot(body, elements) || !better_off_explicit(body, elements, *problem.scene.time.step_s)) continue;
    body.small_steps.resize(body.mesh.elements.size(), false);
    for (const int e : elements) {
      body.small_steps[at(e)] = true;
      body.implicit_element[at(e)] = false;
    }
  }
}

}  // namespace ricochet::scene
