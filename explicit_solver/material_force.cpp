#include "explicit_solver/material_force.hpp"

#include "common/body/material_elements.hpp"

namespace ricochet::explicit_solver {

std::unique_ptr<solver::InternalForce> material_force(const solver::BodyState& state, const std::vector<int>& driven) {
  if (state.plastic || state.frame) return solver::material_elements(state);
  return linear_force(state, driven);
}

}  // namespace ricochet::explicit_solver
