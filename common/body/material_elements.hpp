#pragma once

#include <memory>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::solver {

/// P of a part by its material and its body: LinearElements or PlasticElements, of one that turns in TurningElements.
/// `state` must outlive it unmoved.
[[nodiscard]] std::unique_ptr<InternalForce> material_elements(const BodyState& state);

}  // namespace ricochet::solver
