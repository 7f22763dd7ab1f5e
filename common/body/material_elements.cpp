#include "common/body/material_elements.hpp"

#include <utility>

#include "common/body/hanging_elements.hpp"
#include "common/body/linear_elements.hpp"
#include "common/body/plastic_elements.hpp"
#include "common/body/turning_elements.hpp"

namespace ricochet::solver {

std::unique_ptr<InternalForce> straining_elements(const BodyState& state) {
  if (!state.plastic) return linear_elements(state);
  std::unique_ptr<InternalForce> elements = std::make_unique<PlasticElements>(state);
  if (state.part.mesh.hanging.empty()) return elements;
  return std::make_unique<HangingElements>(state, std::move(elements));
}

std::unique_ptr<InternalForce> material_elements(const BodyState& state) {
  if (!state.frame) return straining_elements(state);
  return std::make_unique<TurningElements>(state, straining_elements(state));
}

}  // namespace ricochet::solver
