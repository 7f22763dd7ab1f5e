#include "implicit_solver/subtrees.hpp"

#include <algorithm>

namespace ricochet::implicit_solver {
namespace {

/// Entries of L below which threads are not worth waking.
constexpr double least_entries = 2e5;
/// Subtrees per thread, so that all have the same to do in the end though subtrees differ in size.
constexpr int subtrees_per_thread = 4;
/// Entries that are worth a strip of their own.
constexpr double least_entries_of_strip = 1e4;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Tree {
  std::vector<int> parent;              ///< of a block; the number of blocks: none but the root
  std::vector<std::vector<int>> child;  ///< of each block, and of that root
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
  tree.parent.resize(at(count));
  tree.child.resize(at(count) + 1);
  tree.blocks.assign(at(count) + 1, 1);
  tree.entries.assign(at(count) + 1, 0.0);
  for (int b = 0; b < count; ++b) {
    const Block& block = blocks[at(b)];
    const int next = block.rows > 0 ? row[at(block.first_row)] : interior;
    const int parent = next < interior ? block_of[at(next)] : count;
    tree.parent[at(b)] = parent;
    tree.child[at(parent)].push_back(b);
    tree.entries[at(b)] += block.entries();
    tree.blocks[at(parent)] += tree.blocks[at(b)];
    tree.entries[at(parent)] += tree.entries[at(b)];
  }
  return tree;
}

/// Opens the largest subtree until none is more than its share; what was opened is the top.
void split(const Tree& tree, int threads, std::vector<int>& roots, std::vector<int>& top) {
  const auto smaller = [&](int a, int b) { return tree.entries[at(a)] < tree.entries[at(b)]; };
  const double share = tree.entries.back() / (threads * subtrees_per_thread);
  roots = tree.child.back();
  std::make_heap(roots.begin(), roots.end(), smaller);
  while (!roots.empty() && tree.entries[at(roots.front())] > share) {
    std::pop_heap(roots.begin(), roots.end(), smaller);
    const int opened = roots.back();
    roots.pop_back();
    top.push_back(opened);
    for (const int child : tree.child[at(opened)]) {
      roots.push_back(child);
      std::push_heap(roots.begin(), roots.end(), smaller);
    }
  }
  std::sort(roots.begin(), roots.end(), [&](int a, int b) { return smaller(b, a); });
  std::sort(top.begin(), top.end());
}

class Planner {
 public:
  Planner(const std::vector<Block>& blocks, const std::vector<int>& row, Subtrees& plan)
      : blocks_(blocks), row_(row), plan_(plan) {}

  /// The strips of the unknowns first ... end - 1, with the rows of the blocks first_below ... block - 1.
  void add_top(int first_below, int block, int first, int end, int threads) {
    const std::vector<RowsOfBlock> rows = rows_within(first_below, block, first, end);
    double entries = 0.0;
    for (const RowsOfBlock& r : rows) entries += static_cast<double>(r.end - r.begin) * blocks_[at(r.block)].width;
    const int strips =
        std::clamp(static_cast<int>(entries / least_entries_of_strip), 1, std::max(1, std::min(threads, end - first)));
    const int first_strip = static_cast<int>(plan_.strips.size());
    for (int s = 0; s < strips; ++s)
      add_strip(rows, first + (end - first) / strips * s, s + 1 < strips ? first + (end - first) / strips * (s + 1) : end);
    plan_.top.push_back({block, first_strip, first_strip + strips});
  }

 private:
  [[nodiscard]] RowsOfBlock within(const RowsOfBlock& rows, int first, int end) const {
    const int* begin_row = row_.data() + blocks_[at(rows.block)].first_row;
    const int* low = std::lower_bound(begin_row + rows.begin, begin_row + rows.end, first);
    const int* high = std::lower_bound(low, begin_row + rows.end, end);
    return {rows.block, static_cast<int>(low - begin_row), static_cast<int>(high - begin_row)};
  }
  [[nodiscard]] std::vector<RowsOfBlock> rows_within(int first_below, int block, int first, int end) const {
    std::vector<RowsOfBlock> found;
    for (int b = first_below; b < block; ++b) {
      const RowsOfBlock rows = within({b, 0, blocks_[at(b)].rows}, first, end);
      if (rows.begin < rows.end) found.push_back(rows);
    }
    return found;
  }
  void add_strip(const std::vector<RowsOfBlock>& rows, int first, int end) {
    Subtrees::Strip strip{first, end, static_cast<int>(plan_.sources.size()), 0};
    for (const RowsOfBlock& all : rows) {
      const RowsOfBlock mine = within(all, first, end);
      if (mine.begin < mine.end) plan_.sources.push_back(mine);
    }
    strip.end_source = static_cast<int>(plan_.sources.size());
    plan_.strips.push_back(strip);
  }

  const std::vector<Block>& blocks_;
  const std::vector<int>& row_;
  Subtrees& plan_;
};

}  // namespace

Subtrees plan_subtrees(std::vector<Block>& blocks, const std::vector<int>& row, int interior, int unknowns,
                       int threads) {
  const int count = static_cast<int>(blocks.size());
  Subtrees plan;
  const Tree tree = tree_of(blocks, row, interior);
  for (Block& block : blocks) block.inner = block.rows;
  if (threads <= 1 || tree.entries.back() < least_entries) {
    plan.subtrees.push_back({0, count, 0, unknowns});
    return plan;
  }
  std::vector<int> roots, top;
  split(tree, threads, roots, top);
  const auto first_below = [&](int block) { return block + 1 - tree.blocks[at(block)]; };
  for (const int root : roots) {
    const int end = blocks[at(root)].end();
    for (int b = first_below(root); b <= root; ++b) {
      const auto first_row = row.begin() + blocks[at(b)].first_row;
      blocks[at(b)].inner = static_cast<int>(std::lower_bound(first_row, first_row + blocks[at(b)].rows, end) - first_row);
    }
    plan.subtrees.push_back({first_below(root), root + 1, blocks[at(first_below(root))].first, end});
  }
  Planner planner(blocks, row, plan);
  for (const int block : top)
    planner.add_top(first_below(block), block, blocks[at(block)].first, blocks[at(block)].end(), threads);
  planner.add_top(0, count, interior, unknowns, threads);
  return plan;
}

}  // namespace ricochet::implicit_solver
