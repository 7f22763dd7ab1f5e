#pragma once

#include <cholmod.h>

#include <vector>

namespace ricochet::implicit_solver {

/// Neighbouring columns of L that are stored as one dense block.
struct ColumnRange {
  int first, width;
};

/// In which order a symmetric positive definite operator is eliminated, and which columns of L form dense blocks.
struct EliminationOrder {
  std::vector<int> order;           ///< unknowns, the interior first, then the root
  std::vector<ColumnRange> blocks;  ///< of the interior
};

/// Constrained minimum degree with `root` last, in the caller's order, the interior in a postorder of its elimination
/// tree, so that columns of one structure stand side by side. `matrix`: upper triangle. Throws SolverError if CHOLMOD
/// runs out of memory.
[[nodiscard]] EliminationOrder elimination_order(cholmod_sparse* matrix, const std::vector<int>& root,
                                                 cholmod_common& common);

}  // namespace ricochet::implicit_solver
