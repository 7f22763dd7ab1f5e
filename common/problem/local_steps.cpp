#include "common/problem/local_steps.hpp"

#include <algorithm>
#include <utility>

#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"

namespace ricochet::scene {

namespace {

/// Per degree of freedom of a part, 0 where held; `node_mass_kg` per node of the part.
Eigen::VectorXd inverse_mass(const BodyProblem& body, const fem::Part& part, const Eigen::VectorXd& node_mass_kg) {
  const int components = fem::components(body.section.model);
  Eigen::VectorXd inverse(part.dofs());
  for (int dof = 0; dof < part.dofs(); ++dof) {
    const int node = dof / components, of_body = part.body_node[at(node)];
    inverse[dof] = body.fixed_dof[at(of_body * components + dof % components)] ? 0.0 : 1.0 / node_mass_kg[node];
  }
  return inverse;
}

}  // namespace

fem::LocalSteps expected_local_steps(const BodyProblem& body, const fem::Part& part, double window_s) {
  return {part.stiffness, inverse_mass(body, part, part.lumped_mass), fem::components(body.section.model), window_s,
          fem::LocalSteps::Levels::expected};
}

fem::LocalSteps local_steps(const Problem& problem, int index, const fem::Part& part, const std::vector<int>& shared,
                            double window_s) {
  const BodyProblem& body = problem.bodies[at(index)];
  if (body.small_steps.empty()) return {};
  const int components = fem::components(body.section.model);
  fem::LocalSteps::Nodes nodes{std::vector<bool>(at(part.nodes()), false), std::vector<bool>(at(part.nodes()), false)};
  for (std::size_t e = 0; e < part.body_element.size(); ++e)
    if (body.small_steps[at(part.body_element[e])])
      fem::for_each_carrier(part.mesh, part.mesh.elements[e], [&](int node) { nodes.may_be_stiff[at(node)] = true; });
  for (const int node : shared) nodes.whole[at(node)] = true;
  for (int node = 0; problem.scene.coupling.protocol.coupled() && node < part.nodes(); ++node)
    if (!body.damping_kg_s.segment(part.body_node[at(node)] * components, components).isZero(0.0))
      nodes.whole[at(node)] = true;
  Eigen::VectorXd mass_kg = part.lumped_mass;
  if (!shared.empty()) {
    const Eigen::VectorXd whole_kg = body_lumped_mass(body);
    for (const int node : shared) mass_kg[node] = whole_kg[part.body_node[at(node)]];
  }
  return {part.stiffness, inverse_mass(body, part, mass_kg), components,
          window_s,       fem::LocalSteps::Levels::borne,    std::move(nodes)};
}

double extra_rows(const Problem& problem, int body, const fem::LocalSteps& steps) {
  if (!steps.any()) return 0.0;
  const std::vector<int> contact = contact_nodes(problem.contacts, body);
  const bool inside = std::any_of(contact.begin(), contact.end(), [&](int node) { return steps.steps_locally(node); });
  return (inside ? 2.0 : 1.0) * steps.extra_rows();
}

bool takes_local_steps(const Problem& problem) {
  const Scene& scene = problem.scene;
  const bool penalty = !scene.contacts.empty() && scene.contact_law().enforcement == Enforcement::penalty;
  return scene.time.step_s && scene.time.one_step() && scene.coupling.substeps == 1 && !penalty &&
         !scene.massless_contact();
}

}  // namespace ricochet::scene
