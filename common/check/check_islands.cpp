#include "common/check/check_islands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/fem/element.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

constexpr std::size_t elements_named = 5;

/// Per node the lowest node that implicit elements join it to.
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
  }
  for (int node = 0; node < static_cast<int>(parent.size()); ++node) parent[at(node)] = root(node);
  return parent;
}

double step_of_element(const BodyProblem& body, int e) {
  return 2.0 / std::sqrt(fem::element_max_frequency_squared(body.section, body.material,
                                                            fem::element_geometry(body.mesh, e)));
}

void find_shortest(const BodyProblem& body, const std::vector<int>& elements, Islands& islands) {
  std::vector<std::pair<double, int>> steps;
  for (const int e : elements) steps.emplace_back(step_of_element(body, e), e);
  const auto count = std::min(elements_named, steps.size());
  std::partial_sort(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(count), steps.end());
  for (std::size_t i = 0; i < count; ++i) {
    islands.shortest_s.push_back(steps[i].first);
    islands.shortest.push_back(steps[i].second);
  }
}

Islands islands_of_body(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  const std::vector<int> joined = joined_by_implicit(body);
  std::vector<bool> held(joined.size(), false), counted(joined.size(), false);
  for (const int node : contact_nodes(problem.contacts, index)) held[at(joined[at(node)])] = true;
  for (std::size_t n = 0; n < body.joined_node.size(); ++n)
    if (body.joined_node[n]) held[at(joined[n])] = true;
  Islands islands{.body = index, .shortest = {}, .shortest_s = {}};
  std::vector<int> elements;
  std::vector<bool> of_island(joined.size(), false), of_explicit(joined.size(), false);
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const auto& nodes = body.mesh.elements[at(e)];
    const int root = joined[at(nodes[0])];
    const bool island = body.implicit_element[at(e)] && !held[at(root)];
    if (island) elements.push_back(e);
    if (island && !counted[at(root)]) ++islands.islands;
    if (island) counted[at(root)] = true;
    for (const int node : nodes) {
      if (island) of_island[at(node)] = true;
      if (!body.implicit_element[at(e)]) of_explicit[at(node)] = true;
    }
  }
  islands.elements = static_cast<int>(elements.size());
  for (std::size_t n = 0; n < of_island.size(); ++n) {
    islands.nodes += of_island[n];
    islands.shared_nodes += of_island[n] && of_explicit[n];
  }
  find_shortest(body, elements, islands);
  return islands;
}

}  // namespace

std::vector<Islands> islands_of(const Problem& problem) {
  std::vector<Islands> all;
  const Scene& scene = problem.scene;
  if (scene.coupling.protocol.layout != Layout::hybrid || scene.partition.rule != PartitionRule::automatic) return all;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    Islands islands = islands_of_body(problem, index);
    if (islands.islands > 0) all.push_back(std::move(islands));
  }
  return all;
}

std::string text_of(const Problem& problem, const Islands& islands) {
  const BodyProblem& body = problem.bodies[at(islands.body)];
  std::string elements;
  for (std::size_t i = 0; i < islands.shortest.size(); ++i) {
    const int e = islands.shortest[i];
    elements += fmt::format("{}{} at {} ({:.3g} s)", i == 0 ? "" : ", ", e,
                            fem::place_text(body.mesh.model, body.mesh.position[at(body.mesh.elements[at(e)][0])]),
                            islands.shortest_s[i]);
  }
  return fmt::format(
      "body '{}' has {} island{} of {} implicit elements away from every contact, whose own steps are below the step "
      "of {:.3g} s; they share {} of their {} nodes with explicit elements. Shortest: {}. {}",
      body.name, islands.islands, islands.islands == 1 ? "" : "s", islands.elements, problem.clock.size_s(),
      islands.shared_nodes, islands.nodes, elements,
      islands.slivers() ? "Mend these elements, or take local_explicit, which needs no implicit ones"
                        : "A zone that was made fine is right to be implicit");
}

}  // namespace ricochet::scene
