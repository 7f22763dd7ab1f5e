#include "implicit_solver/elimination_order.hpp"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::implicit_solver {
namespace {

/// Zeros that a block may store, as a share of it: the solve takes as long as its factor takes to read, so not many.
constexpr double padding_share = 0.1;

/// Entries of L per unknown above which another order is tried. Plane meshes stay below it.
constexpr double dense_share = 100.0;

/// Its calls fail for lack of memory, which is no fault of the scene.
[[noreturn]] void refuse_order(const cholmod_common& common) {
  if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  throw SolverError("CHOLMOD could not order the implicit operator");
}

/// Fill-reducing order that keeps the root unknowns last.
std::vector<int> minimum_degree(cholmod_sparse* matrix, const std::vector<int>& root, cholmod_common& common) {
  std::vector<int> group(matrix->ncol, 0), order(matrix->ncol);
  if (matrix->ncol < 2) return order;  // CAMD writes past the end of a matrix of one row
  for (const int unknown : root) group[static_cast<std::size_t>(unknown)] = 1;
  if (!cholmod_camd(matrix, nullptr, 0, group.data(), order.data(), &common)) refuse_order(common);
  return order;
}

/// Nested dissection of the whole graph, the root taken out of it and put last: of solids it leaves a half or a third
/// of the entries that minimum degree leaves.
std::vector<int> dissection(cholmod_sparse* matrix, const std::vector<int>& root, cholmod_common& common) {
  std::vector<int> whole(matrix->ncol), order;
  if (!cholmod_metis(matrix, nullptr, 0, 0, whole.data(), &common)) refuse_order(common);
  std::vector<bool> in_root(matrix->ncol, false);
  for (const int unknown : root) in_root[static_cast<std::size_t>(unknown)] = true;
  std::copy_if(whole.begin(), whole.end(), std::back_inserter(order),
               [&](int unknown) { return !in_root[static_cast<std::size_t>(unknown)]; });
  order.resize(matrix->ncol);
  return order;
}

/// The root in the caller's order.
void restore_root(const std::vector<int>& root, std::vector<int>& order) {
  std::copy(root.begin(), root.end(), order.end() - static_cast<std::ptrdiff_t>(root.size()));
}

/// Elimination tree of the reordered operator.
std::vector<int> elimination_tree(cholmod_sparse* matrix, std::vector<int>& order, cholmod_common& common) {
  cholmod_sparse* lower = cholmod_ptranspose(matrix, 0, order.data(), nullptr, 0, &common);
  cholmod_sparse* upper = lower ? cholmod_transpose(lower, 0, &common) : nullptr;
  std::vector<int> parent(order.size());
  const bool found = upper && cholmod_etree(upper, parent.data(), &common);
  cholmod_free_sparse(&lower, &common);
  cholmod_free_sparse(&upper, &common);
  if (!found) refuse_order(common);
  return parent;
}

/// Reorders the interior so that columns of one structure follow one another; changes neither fill nor what comes last.
void postorder(cholmod_sparse* matrix, int interior, std::vector<int>& order, cholmod_common& common) {
  std::vector<int> parent = elimination_tree(matrix, order, common), post(order.size());
  for (int j = 0; j < interior; ++j) {
    int& p = parent[static_cast<std::size_t>(j)];
    if (p >= interior) p = -1;
  }
  const auto size = static_cast<std::size_t>(interior);
  if (cholmod_postorder(parent.data(), size, nullptr, post.data(), &common) != interior) refuse_order(common);
  const std::vector<int> before = order;
  for (std::size_t k = 0; k < size; ++k) order[k] = before[static_cast<std::size_t>(post[k])];
}

/// Joins a column to the block before it while that is its only child in the tree's order and little padding is stored.
std::vector<ColumnRange> plan_blocks(const std::vector<int>& parent, const int* column_count, int interior) {
  std::vector<ColumnRange> blocks;
  std::size_t stored = 0;  // entries of the present block that are no padding
  for (int j = 0; j < interior; ++j) {
    const auto below = static_cast<std::size_t>(column_count[j] - 1);
    bool joined = false;
    if (j > 0 && parent[static_cast<std::size_t>(j - 1)] == j) {
      const auto width = static_cast<std::size_t>(blocks.back().width) + 1;
      const std::size_t room = width * (width - 1) / 2 + width * below, padding = room - stored - below;
      joined = static_cast<double>(padding) <= padding_share * static_cast<double>(room);
    }
    if (!joined) {
      blocks.push_back({j, 0});
      stored = 0;
    }
    stored += below;
    ++blocks.back().width;
  }
  return blocks;
}

struct Plan {
  EliminationOrder order;
  double entries = 0.0;  ///< of L
};

/// `order`: the root's places are given, not yet its unknowns.
Plan plan_of(std::vector<int> order, cholmod_sparse* matrix, const std::vector<int>& root, cholmod_common& common) {
  Plan plan{{std::move(order), {}}};
  std::vector<int>& unknowns = plan.order.order;
  const int interior = static_cast<int>(unknowns.size() - root.size());
  restore_root(root, unknowns);
  postorder(matrix, interior, unknowns, common);
  const std::vector<int> parent = elimination_tree(matrix, unknowns, common);
  cholmod_factor* symbolic = cholmod_analyze_p(matrix, unknowns.data(), nullptr, 0, &common);
  if (!symbolic) refuse_order(common);
  const auto* column_count = static_cast<const int*>(symbolic->ColCount);
  plan.order.blocks = plan_blocks(parent, column_count, interior);
  for (int j = 0; j < interior; ++j) plan.entries += column_count[j];
  cholmod_free_factor(&symbolic, &common);
  return plan;
}

}  // namespace

EliminationOrder elimination_order(cholmod_sparse* matrix, const std::vector<int>& root, cholmod_common& common) {
  Plan plan = plan_of(minimum_degree(matrix, root, common), matrix, root, common);
  if (plan.entries <= dense_share * static_cast<double>(matrix->ncol)) return plan.order;
  Plan other = plan_of(dissection(matrix, root, common), matrix, root, common);
  return other.entries < plan.entries ? other.order : plan.order;
}

}  // namespace ricochet::implicit_solver
