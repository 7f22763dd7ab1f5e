#include "common/problem/local_steps.hpp"

namespace ricochet::scene {

fem::LocalSteps local_steps(const BodyProblem& body, const fem::Part& part, double window_s) {
  const int components = fem::components(body.section.model);
  Eigen::VectorXd inverse_mass(part.dofs());
  for (Eigen::Index dof = 0; dof < inverse_mass.size(); ++dof) {
    const bool fixed = body.fixed_dof[static_cast<std::size_t>(dof)];
    inverse_mass[dof] = fixed ? 0.0 : 1.0 / part.lumped_mass[dof / components];
  }
  return {part.stiffness, inverse_mass, components, window_s};
}

}  // namespace ricochet::scene
