#pragma once

#include <vector>

#include "common/fem/part.hpp"

namespace ricochet::fem {

/// A 3 x 3 block of K, each column filled up to four numbers, which a processor loads at once.
struct alignas(32) StencilBlock {
  double column[3][4] = {};
};

/// K u of three components per node, without K. The *stencil* of a node is its three rows of K: how far each
/// neighbour's number is from its own, and the 3 x 3 block of each. K has 27 blocks, 243 numbers, a node; but nodes
/// among copies of the same elements, as structured, swept and periodic meshes are made of, have the same stencil,
/// and each distinct one is stored once (Solid::relative makes copies equal to the last bit). A mesh without copies
/// stores every node's, which is K by blocks.
class NodeStencils {
 public:
  NodeStencils() = default;
  explicit NodeStencils(const SparseMatrix& stiffness);

  /// result = K u [N] in the rows of the nodes first ... end - 1. `follows` per component: 1 if u is taken relative to
  /// the row's own node, else 0 (StiffnessProduct). A node's sum runs in a fixed order.
  void multiply(const double* u, double* result, int first, int end, const double* follows) const;

  [[nodiscard]] int nodes() const { return static_cast<int>(stencil_.size()); }
  [[nodiscard]] int distinct() const { return static_cast<int>(begin_.size()) - 1; }

 private:
  template <bool more>
  void multiply_node(const double* u, double* result, int node, const double* follows) const;
  void multiply_nodes(const double* u, double* result, int first, int end, const double* follows) const;
  void multiply_nodes_by_avx2(const double* u, double* result, int first, int end, const double* follows) const;

  std::vector<int> stencil_;               ///< of each node
  std::vector<int> begin_{0};              ///< blocks of stencil s: begin_[s] .. begin_[s + 1]
  std::vector<int> distance_;              ///< per block: from the node's first dof to the neighbour's
  std::vector<StencilBlock> coefficient_;  ///< per block
};

}  // namespace ricochet::fem
