#pragma once

#include <cstddef>
#include <vector>

namespace ricochet::implicit_solver {

/// Neighbouring columns of L whose structures are the same but for themselves, dense: a strictly lower triangle (width x
/// width, column-major), then a rectangle (rows x width, column-major).
struct Block {
  int first, width;     ///< columns first .. first + width - 1
  int rows, first_row;  ///< rows below, row[first_row ...], ascending
  int inner;            ///< so many of them are unknowns of the same subtree
  std::size_t values;   ///< index of the first value

  [[nodiscard]] int end() const { return first + width; }
  [[nodiscard]] double entries() const { return 0.5 * width * (width - 1) + static_cast<double>(rows) * width; }
};

/// Rows of a block: row[first_row + begin] ... row[first_row + end - 1].
struct RowsOfBlock {
  int block, begin, end;
};

/// Who of several threads may eliminate what. Blocks of L form a tree, a block below the one that holds its first row;
/// they are numbered in a postorder, so that a subtree is blocks (and unknowns) in a row.
///
/// *Subtrees* share no unknown and are eliminated beside each other, each within itself. The blocks above them, the
/// *top*, and at last the root are eliminated one after the other: each first takes from its own unknowns what all
/// blocks before it have to subtract there, in the order of the blocks, several threads a *strip* of unknowns each. An
/// unknown's sum is thus made in the order of the blocks, as without threads, whichever thread makes it.
struct Subtrees {
  struct Subtree {
    int first_block, end_block;
    int first_unknown, end_unknown;
  };
  /// Unknowns, and the rows of earlier blocks that are among them: sources[first_source ...].
  struct Strip {
    int first_unknown, end_unknown;
    int first_source, end_source;
  };
  struct Top {
    int block;
    int first_strip, end_strip;
  };
  std::vector<Subtree> subtrees;  ///< the largest first
  std::vector<Top> top;           ///< in the order of the blocks; last the root, whose block is one past the last
  std::vector<Strip> strips;
  std::vector<RowsOfBlock> sources;
};

/// `row`: of the blocks; `interior`, `unknowns`: the root is interior ... unknowns - 1. With one thread, or few entries,
/// all blocks are one subtree, which reaches down to the root.
/// Sets Block::inner.
[[nodiscard]] Subtrees plan_subtrees(std::vector<Block>& blocks, const std::vector<int>& row, int interior,
                                     int unknowns, int threads);

}  // namespace ricochet::implicit_solver
