#pragma once

#include <vector>

#include "common/cost/node_graph.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::cost {

/// Time and memory that a body of modes takes, on the machine of predicted_cost.cpp.
struct ReducedCost {
  double window_s = 0.0;  ///< a trial and the window itself: dense products
  double setup_s = 0.0;   ///< two factors, solves for the modes and for the shared unknowns
  double bytes = 0.0;     ///< of factor, shapes and Krylov vectors, while the modes are found
};
/// `owned`: its elements that are modes; `factor` of their stiffness, which takes `factor_s` to find and `solve_s` for
/// a solve [s]; `windows` of the run.
[[nodiscard]] ReducedCost reduced_cost(const scene::Problem& problem, const scene::BodyProblem& body,
                                       const std::vector<bool>& owned, const FactorSize& factor, double factor_s,
                                       double solve_s, double windows);

}  // namespace ricochet::cost
