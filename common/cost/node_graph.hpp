#pragma once

#include <vector>

#include "common/fem/mesh.hpp"
#include "common/fem/neighbours.hpp"

namespace ricochet::cost {

/// The nodes of some elements of a body, and which of them share one: what K of these elements has entries for.
struct NodeGraph {
  std::vector<int> node;       ///< of the body's mesh, ascending
  fem::Neighbours neighbours;  ///< by index into `node`

  [[nodiscard]] int nodes() const { return static_cast<int>(node.size()); }
};

[[nodiscard]] NodeGraph node_graph(const fem::Mesh& mesh, const std::vector<bool>& of_element);

/// The size of the Cholesky factor of a matrix with `components` rows a node, after CHOLMOD's own order.
struct FactorSize {
  double entries = 0.0;
  double flops = 0.0;  ///< to find it, as CHOLMOD counts them: the sum of the squares of the columns' entries

  FactorSize& operator+=(const FactorSize& other) {
    entries += other.entries;
    flops += other.flops;
    return *this;
  }
};
/// Symbolic: it takes some microseconds a node and no matrix. Throws std::bad_alloc.
[[nodiscard]] FactorSize factor_size(const NodeGraph& graph, int components);

/// Mean share of the nodes that a wave has reached in `steps` steps from nodes of the body that are `driven`: one
/// neighbour further in every step, as the explicit solver's front goes.
[[nodiscard]] double reached_share(const NodeGraph& graph, const std::vector<int>& driven, double steps);

}  // namespace ricochet::cost
