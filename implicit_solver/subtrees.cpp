#include "implicit_solver/subtrees.hpp"

#include <algorithm>

namespace ricochet::implicit_solver {
namespace {

/// Entries of L below which threads are not worth waking.
constexpr double least_entries = 2e5;
/// A subtree has at most this share of L: the more there are, the better threads are kept busy, and the more is above
/// them.
constexpr double largest_share = 1.0 / 16.0;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Tree {
  std::vector<std::vector<int>> child;  ///< of each block, and last of the root
  std::vector<int> blocks;              ///< of a subtree
  std::vector<double> entries;
};

Tree tree_of(const std::vector<Block>& blocks, const std::vector<int>& row, int interior) {
  const int count = static_cast<int>(blocks.size());
  std::vector<int> block_of(at(interior));
  for (int b = 0; b < count; ++b) {
    for (int j = blocks[at(b)].first; j < blocks[at(b)].end(); ++j) block_of[at(j)] = b;
  }
  Tree tree;
  tree.child.resize(at(count) + 1);
  tree.blocks.assign(at(count) + 1, 1);
  tree.entries.assign(at(count) + 1, 0.0);
  for (int b = 0; b < count; ++b) {
    const Block& block = blocks[at(b)];
    const int next = block.rows > 0 ? row[at(block.first_row)] : interior;
    const int parent = next < interior ? block_of[at(next)] : count;
    tree.child[at(parent)].push_back(b);
    tree.entries[at(b)] += block.entries();
    tree.blocks[at(parent)] += tree.blocks[at(b)];
    tree.entries[at(parent)] += tree.entries[at(b)];
  }
  return tree;
}

}  // namespace

Subtrees divide(const std::vector<Block>& blocks, const std::vector<int>& row, int interior) {
  const int count = static_cast<int>(blocks.size());
  const Tree tree = tree_of(blocks, row, interior);
  Subtrees result;
  if (tree.entries.back() < least_entries) {
    result.subtrees.push_back({0, count, 0, interior});
    return result;
  }
  std::vector<int> open = tree.child.back(), roots;
  while (!open.empty()) {
    const int block = open.back();
    open.pop_back();
    if (tree.entries[at(block)] <= largest_share * tree.entries.back()) {
      roots.push_back(block);
      continue;
    }
    result.top.push_back(block);
    open.insert(open.end(), tree.child[at(block)].begin(), tree.child[at(block)].end());
  }
  std::sort(result.top.begin(), result.top.end());
  std::sort(roots.begin(), roots.end(), [&](int a, int b) {
    return tree.entries[at(a)] != tree.entries[at(b)] ? tree.entries[at(a)] > tree.entries[at(b)] : a < b;
  });
  for (const int root : roots) {
    const int first = root + 1 - tree.blocks[at(root)];
    result.subtrees.push_back({first, root + 1, blocks[at(first)].first, blocks[at(root)].end()});
  }
  return result;
}

}  // namespace ricochet::implicit_solver
