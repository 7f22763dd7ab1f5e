#pragma once

#include <memory>
#include <vector>

#include "explicit_solver/linear_force.hpp"

namespace ricochet::explicit_solver {

/// A MakeForce by the material of the part: LinearForce, or solver::PlasticElements of one that yields.
[[nodiscard]] std::unique_ptr<solver::InternalForce> material_force(const solver::BodyState& state,
                                                                    const std::vector<int>& driven);

}  // namespace ricochet::explicit_solver
