#include "common/problem/local_steps.hpp"

#include <algorithm>

namespace ricochet::scene {

fem::LocalSteps local_steps(const BodyProblem& body, const fem::Part& part, double window_s,
                            fem::LocalSteps::Levels levels) {
  const int components = fem::components(body.section.model);
  Eigen::VectorXd inverse_mass(part.dofs());
  for (Eigen::Index dof = 0; dof < inverse_mass.size(); ++dof) {
    const bool fixed = body.fixed_dof[static_cast<std::size_t>(dof)];
    inverse_mass[dof] = fixed ? 0.0 : 1.0 / part.lumped_mass[dof / components];
  }
  return {part.stiffness, inverse_mass, components, window_s, levels};
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
  const bool turns =
      std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const Body& body) { return body.large_rotation; });
  return !turns && scene.time.step_s && scene.time.changes.empty() && scene.coupling.substeps == 1 && !penalty &&
         !scene.massless_contact();
}

}  // namespace ricochet::scene
