#include "common/problem/islands.hpp"

#include <algorithm>
#include <numeric>

#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

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

bool takes_small_steps(const Scene& scene, const std::string& body) {
  const ProtocolTraits& protocol = scene.coupling.protocol;
  const auto ours = [&](const ParticipantSpec& participant) {
    const bool has_it =
        std::find(participant.bodies.begin(), participant.bodies.end(), body) != participant.bodies.end();
    return participant.role != Role::explicit_solver || !has_it ||
           (!participant.foreign() && !participant.reduced && participant.ranks.value_or(1) == 1 &&
            participant.groups.empty());
  };
  const auto found =
      std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body& b) { return b.name == body; });
  return protocol.layout == Layout::hybrid && !protocol.dual && scene.substeps(body).most == 1 &&
         scene.time.changes.empty() && found != scene.bodies.end() && !found->large_rotation &&
         std::all_of(scene.participants.begin(), scene.participants.end(), ours);
}

/// Few, or not much too stiff for the window: none is as fine as what is better off implicit.
bool better_off_explicit(const BodyProblem& body, const std::vector<int>& elements, double window_s) {
  return elements.size() < sliver_elements || std::all_of(elements.begin(), elements.end(), [&](int e) {
           return element_critical_step(body, e) * finest_explicit >= window_s;
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
  if (!takes_small_steps(problem.scene, body.name)) return;
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
