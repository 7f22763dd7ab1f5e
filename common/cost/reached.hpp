#pragma once

#include "common/cost/node_graph.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::cost {

/// Mean share of the nodes of a body, those of `graph`, that move in the first `steps` steps of a run.
[[nodiscard]] double reached_share(const scene::Problem& problem, int body, const NodeGraph& graph, double steps);

}  // namespace ricochet::cost
