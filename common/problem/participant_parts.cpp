#include <utility>

#include "common/problem/build.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

/// Nodes of a body that explicit participants and the implicit one share: touched by explicit elements and integrated
/// implicitly. None in the baselines.
std::vector<bool> shared_nodes(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  if (problem.scene.coupling.protocol.layout != Layout::hybrid)
    return std::vector<bool>(body.mesh.position.size(), false);
  std::vector<bool> is_explicit = body.implicit_element;
  is_explicit.flip();
  std::vector<bool> shared = touched_nodes(body, is_explicit);
  for (std::size_t i = 0; i < shared.size(); ++i) shared[i] = shared[i] && body.implicit_node[i];
  return shared;
}

ParticipantPart make_part(const Problem& problem, int index, const ParticipantSpec& participant) {
  const BodyProblem& body = problem.bodies[at(index)];
  const std::vector<bool> owned = owned_elements(problem.scene, body, participant);
  std::vector<int> elements, extra_nodes;
  for (std::size_t e = 0; e < owned.size(); ++e)
    if (owned[e]) elements.push_back(static_cast<int>(e));
  if (participant.role == Role::implicit_solver) extra_nodes = contact_nodes(problem.contacts, index);
  ParticipantPart result;
  result.body = index;
  result.part = fem::extract_part(body.mesh, body.name, body.section, body.material, elements, extra_nodes);
  const std::vector<bool> shared = shared_nodes(problem, index);
  for (int i = 0; i < result.part.nodes(); ++i)
    if (shared[at(result.part.body_node[at(i)])]) result.shared.push_back(i);
  return result;
}

}  // namespace

std::vector<ParticipantPart> participant_parts(const Problem& problem, const ParticipantSpec& participant) {
  std::vector<ParticipantPart> parts;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    ParticipantPart part = make_part(problem, index, participant);
    if (part.part.nodes() > 0) parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace ricochet::scene
