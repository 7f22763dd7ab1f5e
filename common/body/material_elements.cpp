#include "common/body/material_elements.hpp"

#include <utility>

#include "common/body/hanging_elements.hpp"
#include "common/body/linear_elements.hpp"
#include "common/body/plastic_elements.hpp"
#include "common/body/turning_elements.hpp"

namespace ricochet::solver {

std::unique_ptr<InternalForce> material_elements(const BodyState& state) {
  std::unique_ptr<InternalForce> elements = linear_elements(state);
  if (state.plastic) elements = std::make_unique<PlasticElements>(state);
  if (state.plastic && !state.part.mesh.hanging.empty())
    elements = std::make_unique<HangingElements>(state, std::move(elements));
  if (state.frame) elements = std::make_unique<TurningElements>(state, std::move(elements));
  return elements;
}

}  // namespace ricochet::solver
