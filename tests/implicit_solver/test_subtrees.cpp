#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "implicit_solver/subtrees.hpp"

namespace ricochet::implicit_solver {
namespace {

/// Two chains of blocks, each `length` long, then a third above both, then the root: a tree of three arms. Each block
/// has as rows the unknowns of the next one of its chain (of a chain's last those of the third), and the root's.
struct Arms {
  static constexpr int width = 100, length = 12, root = 50;
  std::vector<Block> blocks;
  std::vector<int> row;
  int interior = 3 * length * width;

  Arms() {
    for (int b = 0; b < 3 * length; ++b) {
      const int arm = b / length, next = b % length + 1 < length ? b + 1 : arm < 2 ? 2 * length : 3 * length;
      Block block{b * width, width, 0, static_cast<int>(row.size()), 0};
      for (int j = 0; next < 3 * length && j < width; ++j) row.push_back(next * width + j);
      for (int j = 0; j < root; ++j) row.push_back(interior + j);
      block.rows = static_cast<int>(row.size()) - block.first_row;
      blocks.push_back(block);
    }
  }
};

TEST(Subtrees, AndTheTopAreAllOfAFactorEachOnce) {
  const Arms arms;
  const Subtrees result = divide(arms.blocks, arms.row, arms.interior);
  std::vector<int> times(arms.blocks.size(), 0);
  for (const int b : result.top) ++times[static_cast<std::size_t>(b)];
  for (const auto& subtree : result.subtrees) {
    for (int b = subtree.first_block; b < subtree.end_block; ++b) ++times[static_cast<std::size_t>(b)];
    EXPECT_EQ(subtree.first_unknown, arms.blocks[static_cast<std::size_t>(subtree.first_block)].first);
    EXPECT_EQ(subtree.end_unknown, arms.blocks[static_cast<std::size_t>(subtree.end_block) - 1].end());
  }
  EXPECT_EQ(times, std::vector<int>(times.size(), 1));
}

TEST(Subtrees, ReachOutOfThemselvesOnlyToRowsOfTheirLastBlock) {
  const Arms arms;
  const Subtrees result = divide(arms.blocks, arms.row, arms.interior);
  ASSERT_EQ(result.subtrees.size(), 2U);  // the lowest blocks of the two arms that begin
  for (const auto& subtree : result.subtrees) {
    const Block& last = arms.blocks[static_cast<std::size_t>(subtree.end_block) - 1];
    const auto above = arms.row.begin() + last.first_row;
    for (int b = subtree.first_block; b < subtree.end_block; ++b) {
      const Block& block = arms.blocks[static_cast<std::size_t>(b)];
      for (int k = block.first_row; k < block.first_row + block.rows; ++k) {
        const int row = arms.row[static_cast<std::size_t>(k)];
        EXPECT_GE(row, subtree.first_unknown);
        EXPECT_TRUE(row < subtree.end_unknown || std::binary_search(above, above + last.rows, row)) << b;
      }
    }
  }
}

TEST(Subtrees, OfASmallFactorAreOneThatReachesToTheRoot) {
  const std::vector<Block> blocks = {{0, 2, 1, 0, 0}, {2, 1, 0, 1, 0}};
  const Subtrees result = divide(blocks, {2}, 3);
  ASSERT_EQ(result.subtrees.size(), 1U);
  EXPECT_EQ(result.subtrees[0].end_block, 2);
  EXPECT_EQ(result.subtrees[0].end_unknown, 3);
  EXPECT_TRUE(result.top.empty());
}

}  // namespace
}  // namespace ricochet::implicit_solver
