#include <algorithm>
#include <utility>

#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"
#include "common/problem/mass_scaling.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {

std::vector<bool> shared_nodes(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  if (problem.scene.coupling.protocol.layout != Layout::hybrid)
    return std::vector<bool>(body.mesh.position.size(), false);
  std::vector<bool> is_explicit = body.implicit_element;
  is_explicit.flip();
  std::vector<bool> shared = touched_nodes(body, is_explicit);
  for (std::size_t i = 0; i < shared.size(); ++i)
    shared[i] = (shared[i] || body.joined_node[i]) && body.implicit_node[i];
  return shared;
}

namespace {

ParticipantPart make_part(const Problem& problem, int index, const std::vector<int>& elements,
                          const std::vector<int>& extra_nodes) {
  const BodyProblem& body = problem.bodies[at(index)];
  ParticipantPart result;
  result.body = index;
  result.part = body_part(body, elements, extra_nodes);
  const std::vector<bool> shared = shared_nodes(problem, index);
  for (int i = 0; i < result.part.nodes(); ++i)
    if (shared[at(result.part.body_node[at(i)])]) result.shared.push_back(i);
  return result;
}

}  // namespace

std::vector<ParticipantPart> participant_parts(const Problem& problem, const ParticipantSpec& participant) {
  std::vector<ParticipantPart> parts;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const std::vector<bool> owned = owned_elements(problem.scene, problem.bodies[at(index)], participant);
    std::vector<int> elements, extra_nodes;
    for (std::size_t e = 0; e < owned.size(); ++e)
      if (owned[e]) elements.push_back(static_cast<int>(e));
    if (participant.role == Role::implicit_solver) extra_nodes = contact_nodes(problem.contacts, index);
    ParticipantPart part = make_part(problem, index, elements, extra_nodes);
    if (part.part.nodes() > 0) parts.push_back(std::move(part));
  }
  return parts;
}

ParticipantPart part_share(const Problem& problem, int body, const ParticipantSpec& participant,
                           const std::vector<int>& whole, const std::vector<int>& own, const std::vector<int>& with) {
  const BodyProblem& problem_body = problem.bodies[at(body)];
  const std::vector<bool> owned = owned_elements(problem.scene, problem_body, participant);
  std::vector<bool> mine(problem_body.mesh.position.size(), false);
  for (const int node : own) mine[at(node)] = true;
  std::vector<int> elements;
  for (std::size_t e = 0; e < owned.size(); ++e) {
    const auto& nodes = problem_body.mesh.elements[e];
    bool any = false;
    const auto look = [&](int node) { any = any || mine[at(node)]; };
    std::for_each(nodes.begin(), nodes.end(), look);
    fem::for_each_carrier(problem_body.mesh, nodes, look);
    if (owned[e] && any) elements.push_back(static_cast<int>(e));
  }
  ParticipantPart result = make_part(problem, body, elements, with);
  const int components = fem::components(problem_body.mesh.model);
  for (const int node : result.part.body_node) {
    result.own.push_back(mine[at(node)]);
    const auto number = std::lower_bound(whole.begin(), whole.end(), node) - whole.begin();
    result.numbering.number.push_back(static_cast<int>(number));
  }
  result.numbering.count = static_cast<int>(whole.size());
  result.part.stiffness.prune(
      [&](Eigen::Index row, Eigen::Index, double) { return result.own[at(static_cast<int>(row) / components)]; });
  const auto others = [&](int node) { return !result.own[at(node)]; };
  result.shared.erase(std::remove_if(result.shared.begin(), result.shared.end(), others), result.shared.end());
  return result;
}

}  // namespace ricochet::scene
