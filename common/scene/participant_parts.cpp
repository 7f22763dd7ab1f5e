#include <algorithm>

#include "common/scene/build.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

/// Nodes of a body that an explicit and the implicit participant share: touched by elements of both kinds, or contact
/// nodes of explicit elements. None in the baselines.
std::vector<bool> shared_nodes(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  std::vector<bool> shared(body.mesh.position.size(), false);
  if (protocol_traits(problem.scene.coupling.protocol).layout != Layout::hybrid) return shared;
  const std::vector<bool> touched = touched_nodes(body, false);
  for (std::size_t i = 0; i < shared.size(); ++i) shared[i] = touched[i] && body.implicit_node[i];
  return shared;
}

ParticipantPart make_part(const Problem& problem, int index, bool implicit) {
  const BodyProblem& body = problem.bodies[at(index)];
  std::vector<int> elements, extra_nodes;
  for (std::size_t e = 0; e < body.implicit_element.size(); ++e)
    if (body.implicit_element[e] == implicit) elements.push_back(static_cast<int>(e));
  if (implicit) extra_nodes = contact_nodes(problem.contact, index);
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
  const bool implicit = participant.role == Role::implicit_solver;
  std::vector<ParticipantPart> parts;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const std::string& name = problem.bodies[at(index)].name;
    const auto& own = participant.bodies;
    if (!implicit && std::find(own.begin(), own.end(), name) == own.end()) continue;
    ParticipantPart part = make_part(problem, index, implicit);
    if (part.part.nodes() > 0) parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace ricochet::scene
