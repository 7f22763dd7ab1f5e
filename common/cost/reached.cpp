#include "common/cost/reached.hpp"

#include <algorithm>
#include <vector>

namespace ricochet::cost {
namespace {

using fem::at;

/// All that moves a body from the start on: contact, interface, loads, prescribed motion.
std::vector<int> driven_nodes(const scene::Problem& problem, int index) {
  const scene::BodyProblem& body = problem.bodies[at(index)];
  const scene::Body& spec = problem.scene.bodies[at(index)];
  std::vector<int> nodes = scene::contact_nodes(problem.contacts, index);
  const auto add_surface = [&](const std::string& surface) {
    const auto more = fem::surface_nodes(body.mesh, surface);
    nodes.insert(nodes.end(), more.begin(), more.end());
  };
  for (const auto& traction : spec.tractions) add_surface(traction.surface);
  for (const auto& prescribed : spec.prescribed) add_surface(prescribed.surface);
  for (const auto& support : spec.supports) add_surface(support.surface);
  for (int node = 0; node < static_cast<int>(body.implicit_node.size()); ++node)
    if (body.implicit_node[at(node)]) nodes.push_back(node);
  return nodes;
}

bool moves_everywhere(const scene::Body& spec) {
  const auto any = [](const std::vector<double>& values) {
    return std::any_of(values.begin(), values.end(), [](double x) { return x != 0.0; });
  };
  return any(spec.gravity_m_s2) || any(spec.initial_displacement_start_m) || any(spec.initial_displacement_end_m);
}

}  // namespace

double reached_share(const scene::Problem& problem, int body, const NodeGraph& graph, double steps) {
  if (moves_everywhere(problem.scene.bodies[at(body)])) return 1.0;
  return reached_share(graph, driven_nodes(problem, body), steps);
}

}  // namespace ricochet::cost
