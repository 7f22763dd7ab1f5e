#include "common/problem/problem.hpp"

namespace ricochet::scene {

ExternalForce::ExternalForce(const Body& body, const fem::Part& part) {
  const auto add = [&](const Amplitude& amplitude, Eigen::VectorXd force) {
    if (!force.isZero(0.0)) terms_.push_back({amplitude, std::move(force)});
  };
  add({}, fem::gravity_force(part, body.gravity_m_s2));
  for (const Traction& traction : body.tractions) {
    if (traction.pressure_pa != 0.0)
      add(traction.amplitude, fem::pressure_force(part, traction.surface, traction.pressure_pa));
    add(traction.amplitude, fem::traction_force(part, traction.surface, traction.traction_pa));
  }
}

std::vector<bool> ExternalForce::loaded(int dofs) const {
  std::vector<bool> rows(static_cast<std::size_t>(dofs), false);
  for (const Term& term : terms_)
    for (int dof = 0; dof < dofs; ++dof)
      if (term.force[dof] != 0.0) rows[static_cast<std::size_t>(dof)] = true;
  return rows;
}

void ExternalForce::at(double time_s, Eigen::VectorXd& force) const {
  force.setZero();
  for (const Term& term : terms_) force += term.amplitude.at(time_s) * term.force;
}

}  // namespace ricochet::scene
