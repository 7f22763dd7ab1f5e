#include "common/check/check_islands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/fem/element.hpp"
#include "common/problem/automatic_partition.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"

namespace ricochet::scene {
namespace {

constexpr std::size_t elements_named = 5;

void find_shortest(const BodyProblem& body, const std::vector<int>& elements, Islands& islands) {
  std::vector<std::pair<double, int>> steps;
  for (const int e : elements) steps.emplace_back(element_critical_step(body, e), e);
  const auto count = std::min(elements_named, steps.size());
  std::partial_sort(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(count), steps.end());
  for (std::size_t i = 0; i < count; ++i) {
    islands.shortest_s.push_back(steps[i].first);
    islands.shortest.push_back(steps[i].second);
  }
}

void count_nodes(const BodyProblem& body, const std::vector<int>& elements, Islands& islands) {
  std::vector<bool> is_explicit = body.implicit_element, of_island(body.mesh.elements.size(), false);
  is_explicit.flip();
  for (const int e : elements) of_island[at(e)] = true;
  const std::vector<bool> touched = touched_nodes(body, of_island), shared = touched_nodes(body, is_explicit);
  for (std::size_t n = 0; n < touched.size(); ++n) {
    islands.nodes += touched[n];
    islands.shared_nodes += touched[n] && shared[n];
  }
}

Islands islands_of_body(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  Islands islands;
  islands.body = index;
  islands.step_s = automatic_step_s(problem.scene, body.name);
  std::vector<int> all, of_slivers;
  for (const auto& elements : elements_of_islands(problem, index)) {
    islands.elements.push_back(static_cast<int>(elements.size()));
    all.insert(all.end(), elements.begin(), elements.end());
    if (elements.size() >= sliver_elements) continue;
    ++islands.slivers;
    of_slivers.insert(of_slivers.end(), elements.begin(), elements.end());
  }
  count_nodes(body, all, islands);
  find_shortest(body, islands.slivers > 0 ? of_slivers : all, islands);
  return islands;
}

}  // namespace

std::vector<Islands> islands_of(const Problem& problem) {
  std::vector<Islands> all;
  const Scene& scene = problem.scene;
  if (scene.coupling.protocol.layout != Layout::hybrid || scene.partition.rule != PartitionRule::automatic) return all;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    Islands islands = islands_of_body(problem, index);
    if (!islands.elements.empty()) all.push_back(std::move(islands));
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
  const auto count = islands.elements.size();
  const int sum = std::accumulate(islands.elements.begin(), islands.elements.end(), 0);
  return fmt::format(
      "body '{}' has {} island{} of {} implicit elements away from every contact, whose own steps are below {:.3g} s; "
      "they share {} of their {} nodes with explicit elements. {}. Shortest, numbered as in the fields: {}",
      body.name, count, count == 1 ? "" : "s", sum, islands.step_s, islands.shared_nodes, islands.nodes,
      islands.slivers > 0 ? fmt::format("{} of them ha{} fewer than {} elements: mend these{}", islands.slivers,
                                        islands.slivers == 1 ? "s" : "ve", sliver_elements,
                                        problem.scene.coupling.protocol.dual
                                            ? ", or take a primal protocol, whose explicit side takes small steps there"
                                            : "")
                          : "A zone that was made fine is right to be implicit",
      elements);
}

}  // namespace ricochet::scene
