#include "explicit_solver/material_force.hpp"

#include "common/body/plastic_elements.hpp"

namespace ricochet::explicit_solver {

std::unique_ptr<solver::InternalForce> material_force(const solver::BodyState& state, const std::vector<int>& driven) {
  if (state.plastic) return std::make_unique<solver::PlasticElements>(state);
  return linear_force(state, driven);
}

}  // namespace ricochet::explicit_solver
