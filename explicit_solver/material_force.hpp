#pragma once

#include <memory>
#include <vector>

#include "explicit_solver/linear_force.hpp"

namespace ricochet::explicit_solver {

/// A MakeForce by the material of the part and its body: LinearForce, or solver::material_elements of one that yields
/// or turns.
[[nodiscard]] std::unique_ptr<solver::InternalForce> material_force(const solver::BodyState& state,
                                                                    const std::vector<int>& driven);

}  // namespace ricochet::explicit_solver
