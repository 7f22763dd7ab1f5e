#pragma once

#include <cstddef>
#include <vector>

namespace ricochet::implicit_solver {

/// Neighbouring columns of L whose structures are the same but for themselves, dense.
struct Block {
  int first, width;     ///< columns first .. first + width - 1
  int rows, first_row;  ///< rows below, row[first_row ...], ascending
  std::size_t values;   ///< index of the first value

  [[nodiscard]] int end() const { return first + width; }
  [[nodiscard]] double entries() const { return static_cast<double>(width + rows) * width; }
};

/// Parts of L to eliminate side by side. Its blocks form a tree, a block below the one that holds its first row,
/// and are numbered in a postorder, so that a subtree is blocks, and unknowns, in a row. *Subtrees* share no unknown;
/// the blocks above them are the *top*. How L is divided depends on L alone, not on the number of threads, because what
/// subtrees add to unknowns above them is summed subtree by subtree.
struct Subtrees {
  struct Subtree {
    int first_block, end_block;
    int first_unknown, end_unknown;
  };
  std::vector<Subtree> subtrees;  ///< the largest first
  std::vector<int> top;           ///< blocks, ascending
};

/// `row`: of the blocks; the root is all unknowns from `interior` on. If L has few entries, one subtree and no top.
[[nodiscard]] Subtrees divide(const std::vector<Block>& blocks, const std::vector<int>& row, int interior);

}  // namespace ricochet::implicit_solver
