#pragma once

#include <memory>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::solver {

/// P of a part's elements by its material, in the frame of a part that turns: LinearElements or PlasticElements.
/// `state` must outlive it unmoved.
[[nodiscard]] std::unique_ptr<InternalForce> straining_elements(const BodyState& state);
/// P of a part by its material and its body: those, of one that turns in TurningElements.
[[nodiscard]] std::unique_ptr<InternalForce> material_elements(const BodyState& state);

}  // namespace ricochet::solver
