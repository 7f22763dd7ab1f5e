#include "implicit_solver/condensed_factor.hpp"

#include <cholmod.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "common/base/error.hpp"

/// Of OpenMP, with which CHOLMOD may have been compiled.
extern "C" [[gnu::weak]] void omp_set_max_active_levels(int levels);

namespace ricochet::implicit_solver {
namespace {

/// Entries of a block that are worth a thread.
constexpr double least_entries_of_part = 1e4;

/// Where part `part` of `parts` of so many begins.
int share(int of, int part, int parts) { return static_cast<int>(std::int64_t{of} * part / parts); }

/// CHOLMOD's workspace and the objects that must go back to it.
struct Cholmod {
  cholmod_common common{};
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;
  Cholmod() {
    // In supernodes it would start four threads for every short loop, whatever processors there are and `threads` says:
    // they then wait for each other half of the time.
    if (omp_set_max_active_levels != nullptr) omp_set_max_active_levels(0);
    cholmod_start(&common);
    common.print = 0;  // errors are ours to report
  }
  ~Cholmod() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
};

[[noreturn]] void refuse_indefinite() {
  throw SolverError(
      "the implicit operator M + dt^2/4 K is not positive definite: check materials and supports of the "
      "implicit partition");
}

/// CHOLMOD's calls return nothing then: the machine's failure, as any other lack of memory, and no fault of the scene.
[[noreturn]] void refuse_cholmod(const cholmod_common& common, const char* could_not) {
  if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  throw SolverError(std::string("CHOLMOD could not ") + could_not + " the implicit operator");
}

/// Upper triangle of the active rows and columns of A, in CHOLMOD's column form.
cholmod_sparse* upper_triangle(const fem::SparseMatrix& a, const std::vector<int>& unknown_of, int unknowns,
                               cholmod_common& common) {
  // A is symmetric, so row r of the row-major A is column r; entries with unknown row <= r are the upper triangle.
  std::size_t entries = 0;
  const auto visit = [&](auto&& take) {
    for (int r = 0; r < a.outerSize(); ++r) {
      const int column = unknown_of[static_cast<std::size_t>(r)];
      if (column < 0) continue;
      for (fem::SparseMatrix::InnerIterator it(a, r); it; ++it) {
        const int row = unknown_of[static_cast<std::size_t>(it.col())];
        if (row >= 0 && row <= column) take(row, column, it.value());
      }
    }
  };
  visit([&](int, int, double) { ++entries; });
  const auto n = static_cast<std::size_t>(unknowns);
  cholmod_sparse* matrix = cholmod_allocate_sparse(n, n, entries, 1, 1, 1, CHOLMOD_REAL, &common);
  if (!matrix) refuse_cholmod(common, "hold");
  auto* column_start = static_cast<int*>(matrix->p);
  auto* rows = static_cast<int*>(matrix->i);
  auto* values = static_cast<double*>(matrix->x);
  std::fill(column_start, column_start + unknowns + 1, 0);
  visit([&](int, int column, double) { ++column_start[column + 1]; });
  for (int j = 0; j < unknowns; ++j) column_start[j + 1] += column_start[j];
  std::vector<int> next(column_start, column_start + unknowns);
  visit([&](int row, int column, double value) {
    const int at = next[static_cast<std::size_t>(column)]++;
    rows[at] = row;
    values[at] = value;
  });
  return matrix;
}

/// y -= L x, L some rows of a column-major matrix with `stride` of them; four columns at a time, so that y is loaded
/// and stored a quarter as often.
void subtract_product(const double* l, int stride, int rows, int columns, const double* x, double* __restrict y) {
  int c = 0;
  for (; c + 4 <= columns; c += 4) {
    const double* l0 = l + static_cast<std::ptrdiff_t>(c) * stride;
    const double *l1 = l0 + stride, *l2 = l1 + stride, *l3 = l2 + stride;
    const double x0 = x[c], x1 = x[c + 1], x2 = x[c + 2], x3 = x[c + 3];
    for (int i = 0; i < rows; ++i) y[i] -= (l0[i] * x0 + l1[i] * x1) + (l2[i] * x2 + l3[i] * x3);
  }
  for (; c < columns; ++c) {
    const double* l0 = l + static_cast<std::ptrdiff_t>(c) * stride;
    for (int i = 0; i < rows; ++i) y[i] -= l0[i] * x[c];
  }
}

/// x -= L^T y. Four sums side by side per column: a fixed order that vectorises.
void subtract_transposed_product(const double* l, int rows, int columns, const double* y, double* __restrict x) {
  constexpr int lanes = 8;
  for (int c = 0; c < columns; ++c) {
    const double* column = l + static_cast<std::ptrdiff_t>(c) * rows;
    double sums[lanes] = {};
    int i = 0;
    for (; i + lanes <= rows; i += lanes) {
      for (int k = 0; k < lanes; ++k) sums[k] += column[i + k] * y[i + k];
    }
    double sum = ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
    for (; i < rows; ++i) sum += column[i] * y[i];
    x[c] -= sum;
  }
}

}  // namespace

/// CHOLMOD's L L^T, read as L D L^T column by column. Its supernodes are columns that were made alike with zeros, so
/// that dense algebra computes them; these zeros are exact.
class Supernodes {
 public:
  explicit Supernodes(const cholmod_factor& factor)
      : first_(static_cast<const int*>(factor.super)),
        rows_from_(static_cast<const int*>(factor.pi)),
        values_from_(static_cast<const int*>(factor.px)),
        row_(static_cast<const int*>(factor.s)),
        value_(static_cast<const double*>(factor.x)) {
    for (int s = 0; s < static_cast<int>(factor.nsuper); ++s)
      of_column_.resize(static_cast<std::size_t>(first_[s + 1]), s);
  }

  /// Of L L^T.
  [[nodiscard]] double diagonal(int column) const { return column_of(column).values[0]; }
  /// take(row, value) of the column of L, of L D L^T, from the top.
  template <class Take>
  void below_diagonal(int column, const Take& take) const {
    const Column c = column_of(column);
    for (int k = 1; k < c.height; ++k) take(c.rows[k], c.values[k] / c.values[0]);
  }

 private:
  struct Column {
    const int* rows;
    const double* values;
    int height;
  };
  [[nodiscard]] Column column_of(int column) const {
    const int s = of_column_[static_cast<std::size_t>(column)], above = column - first_[s];
    const int height = rows_from_[s + 1] - rows_from_[s];
    return {row_ + rows_from_[s] + above, value_ + values_from_[s] + std::ptrdiff_t{above} * height + above,
            height - above};
  }

  const int *first_, *rows_from_, *values_from_, *row_;
  const double* value_;
  std::vector<int> of_column_;
};

CondensedFactor::CondensedFactor(fem::SparseMatrix a, const std::vector<bool>& active, const std::vector<int>& root,
                                 std::shared_ptr<Parallel> parallel)
    : parallel_(std::move(parallel)) {
  const auto dofs = static_cast<std::size_t>(a.rows());
  std::vector<int> unknown_of(dofs, -1), dof_of_unknown;
  for (std::size_t dof = 0; dof < dofs; ++dof) {
    if (!active[dof]) continue;
    unknown_of[dof] = static_cast<int>(dof_of_unknown.size());
    dof_of_unknown.push_back(static_cast<int>(dof));
  }
  const int unknowns = static_cast<int>(dof_of_unknown.size());
  const int roots = static_cast<int>(root.size());
  interior_ = unknowns - roots;

  Cholmod cholmod;
  auto& common = cholmod.common;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.postorder = 0;  // CHOLMOD's own would move the root
  common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod.matrix = upper_triangle(a, unknown_of, unknowns, common);
  a = fem::SparseMatrix();  // of what is needed at the peak of memory it would be a good part

  std::vector<int> root_unknowns;
  for (const int dof : root) root_unknowns.push_back(unknown_of[static_cast<std::size_t>(dof)]);
  const EliminationOrder plan = elimination_order(cholmod.matrix, root_unknowns, common);
  std::vector<int> order = plan.order;
  common.supernodal = CHOLMOD_SUPERNODAL;
  cholmod.factor = cholmod_analyze_p(cholmod.matrix, order.data(), nullptr, 0, &common);
  if (!cholmod.factor) refuse_cholmod(common, "analyse");
  if (!cholmod_factorize(cholmod.matrix, cholmod.factor, &common)) refuse_cholmod(common, "factorise");
  if (common.status != CHOLMOD_OK || cholmod.factor->minor < cholmod.factor->n) refuse_indefinite();
  cholmod_free_sparse(&cholmod.matrix, &common);

  const Supernodes factor(*cholmod.factor);
  for (int j = 0; j < interior_; ++j) inverse_diagonal_.push_back(1.0 / (factor.diagonal(j) * factor.diagonal(j)));
  for (const int unknown : order) dof_of_.push_back(dof_of_unknown[static_cast<std::size_t>(unknown)]);
  collect_blocks(plan.blocks, factor);
  division_ = divide(blocks_, row_, interior_);
  collect_targets();
  const auto taller = [](const Block& x, const Block& y) { return x.rows < y.rows; };
  const auto tallest = std::max_element(blocks_.begin(), blocks_.end(), taller);
  gathered_.setZero(tallest == blocks_.end() ? 0 : tallest->rows, parallel_ ? parallel_->threads() : 1);

  Eigen::MatrixXd lower = Eigen::MatrixXd::Identity(roots, roots);
  Eigen::VectorXd pivots(roots);
  for (int k = 0; k < roots; ++k) {
    pivots[k] = factor.diagonal(interior_ + k) * factor.diagonal(interior_ + k);
    factor.below_diagonal(interior_ + k, [&](int row, double value) { lower(row - interior_, k) = value; });
  }
  const Eigen::MatrixXd half = lower.triangularView<Eigen::UnitLower>().solve(Eigen::MatrixXd::Identity(roots, roots));
  root_inverse_ = half.transpose() * pivots.cwiseInverse().asDiagonal() * half;
  solution_.setZero(unknowns);
  root_rhs_.setZero(roots);
}

void CondensedFactor::collect_blocks(const std::vector<ColumnRange>& ranges, const Supernodes& factor) {
  std::vector<int> found_by(dof_of_.size(), -1);  // per row: the last block that has it
  std::size_t room = 0;
  for (const ColumnRange& range : ranges) {
    Block block{range.first, range.width, 0, static_cast<int>(row_.size()), room};
    for (int c = range.first; c < block.end(); ++c) {
      factor.below_diagonal(c, [&](int row, double value) {
        int& found = found_by[static_cast<std::size_t>(row)];
        if (row < block.end() || found == range.first || value == 0.0) return;
        found = range.first;
        row_.push_back(row);
      });
    }
    block.rows = static_cast<int>(row_.size()) - block.first_row;
    std::sort(row_.begin() + block.first_row, row_.end());
    room += static_cast<std::size_t>(block.width + block.rows) * static_cast<std::size_t>(block.width);
    blocks_.push_back(block);
  }
  values_.assign(room, 0.0);
  std::vector<int> place(dof_of_.size(), 0);
  for (const Block& block : blocks_) {
    for (int k = 0; k < block.rows; ++k)
      place[static_cast<std::size_t>(row_[static_cast<std::size_t>(block.first_row + k)])] = k;
    double* triangle = values_.data() + block.values;
    double* rectangle = triangle + static_cast<std::ptrdiff_t>(block.width) * block.width;
    for (int c = 0; c < block.width; ++c) {
      factor.below_diagonal(block.first + c, [&](int row, double value) {
        if (value == 0.0) return;
        if (row < block.end()) {
          triangle[c * block.width + row - block.first] = value;
        } else {
          rectangle[c * block.rows + place[static_cast<std::size_t>(row)]] = value;
        }
      });
    }
  }
}

void CondensedFactor::collect_targets() {
  target_ = row_;
  auto next = static_cast<int>(dof_of_.size());
  for (const Subtrees::Subtree& subtree : division_.subtrees) {
    if (division_.top.empty()) break;  // nothing is above it but the root
    const Block& last = blocks_[static_cast<std::size_t>(subtree.end_block) - 1];
    const auto above = row_.begin() + last.first_row, above_end = above + last.rows;
    for (int b = subtree.first_block; b < subtree.end_block; ++b) {
      const Block& block = blocks_[static_cast<std::size_t>(b)];
      for (int k = block.first_row; k < block.first_row + block.rows; ++k) {
        const int row = row_[static_cast<std::size_t>(k)];
        if (row < subtree.end_unknown) continue;
        target_[static_cast<std::size_t>(k)] = next + static_cast<int>(std::lower_bound(above, above_end, row) - above);
      }
    }
    next += last.rows;
  }
  work_.setZero(next);
}

template <class Work>
void CondensedFactor::for_each(int parts, const Work& work) {
  if (parallel_) {
    parallel_->for_each(parts, work);
  } else {
    for (int part = 0; part < parts; ++part) work(part, 0);
  }
}

/// Into how many parts a block of the top is divided.
int CondensedFactor::parts_of(const Block& block) const {
  const int most = parallel_ ? parallel_->threads() : 1;
  return std::clamp(static_cast<int>(block.entries() / least_entries_of_part), 1, most);
}

const double* CondensedFactor::rectangle_of(const Block& block) const {
  return values_.data() + block.values + static_cast<std::ptrdiff_t>(block.width) * block.width;
}

void CondensedFactor::load(const Eigen::VectorXd& b, int first, int end) {
  for (int j = first; j < end; ++j) work_[j] = b[dof_of_[static_cast<std::size_t>(j)]];
}

/// Unknowns of a block from each other.
void CondensedFactor::solve_own(const Block& block) {
  const double* triangle = values_.data() + block.values;
  double* own = work_.data() + block.first;
  for (int c = 0; c + 1 < block.width; ++c) {
    for (int r = c + 1; r < block.width; ++r) own[r] -= triangle[c * block.width + r] * own[c];
  }
}

/// What the unknowns of a block subtract from those of its rows first ... end - 1.
void CondensedFactor::subtract_below(const Block& block, int first, int end, double* y) {
  double* x = work_.data();
  const int* target = target_.data() + block.first_row + first;
  for (int k = 0; k < end - first; ++k) y[k] = x[target[k]];
  subtract_product(rectangle_of(block) + first, block.rows, end - first, block.width, x + block.first, y);
  for (int k = 0; k < end - first; ++k) x[target[k]] = y[k];
}

/// Adds what subtrees have collected for unknowns above them, and empties it.
void CondensedFactor::add_from_subtrees() {
  double* collected = work_.data() + dof_of_.size();
  for (const Subtrees::Subtree& subtree : division_.subtrees) {
    const Block& last = blocks_[static_cast<std::size_t>(subtree.end_block) - 1];
    for (int k = 0; k < last.rows; ++k) {
      work_[row_[static_cast<std::size_t>(last.first_row + k)]] += collected[k];
      collected[k] = 0.0;
    }
    collected += last.rows;
  }
}

void CondensedFactor::forward(const Eigen::VectorXd& b) {
  const int unknowns = static_cast<int>(dof_of_.size());
  load(b, interior_, unknowns);
  for_each(static_cast<int>(division_.subtrees.size()), [&](int part, int thread) noexcept {
    const Subtrees::Subtree& subtree = division_.subtrees[static_cast<std::size_t>(part)];
    load(b, subtree.first_unknown, subtree.end_unknown);
    for (int k = subtree.first_block; k < subtree.end_block; ++k) {
      const Block& block = blocks_[static_cast<std::size_t>(k)];
      solve_own(block);
      subtract_below(block, 0, block.rows, gathered_.col(thread).data());
    }
  });
  for (const int k : division_.top) {
    const Block& block = blocks_[static_cast<std::size_t>(k)];
    load(b, block.first, block.end());
  }
  if (!division_.top.empty()) add_from_subtrees();
  for (const int k : division_.top) {
    const Block& block = blocks_[static_cast<std::size_t>(k)];
    solve_own(block);
    const int parts = parts_of(block);
    for_each(parts, [&](int part, int thread) noexcept {
      subtract_below(block, share(block.rows, part, parts), share(block.rows, part + 1, parts),
                     gathered_.col(thread).data());
    });
  }
  root_rhs_ = work_.segment(interior_, unknowns - interior_);
}

/// What `forward` left, which may be used again, times D^-1.
void CondensedFactor::scale(int first, int end) {
  for (int j = first; j < end; ++j) solution_[j] = work_[j] * inverse_diagonal_[static_cast<std::size_t>(j)];
}

void CondensedFactor::gather_below(const Block& block, double* y) const {
  const int* row = row_.data() + block.first_row;
  for (int k = 0; k < block.rows; ++k) y[k] = solution_[row[k]];
}

void CondensedFactor::solve_own_transposed(const Block& block) {
  const double* triangle = values_.data() + block.values;
  double* own = solution_.data() + block.first;
  for (int c = block.width - 2; c >= 0; --c) {
    for (int r = c + 1; r < block.width; ++r) own[c] -= triangle[c * block.width + r] * own[r];
  }
}

void CondensedFactor::recover_top(const Block& block) {
  double* y = gathered_.col(0).data();
  gather_below(block, y);
  const int parts = parts_of(block);
  for_each(parts, [&](int part, int) noexcept {
    const int first = share(block.width, part, parts), end = share(block.width, part + 1, parts);
    subtract_transposed_product(rectangle_of(block) + static_cast<std::ptrdiff_t>(first) * block.rows, block.rows,
                                end - first, y, solution_.data() + block.first + first);
  });
  solve_own_transposed(block);
}

void CondensedFactor::store(int first, int end, Eigen::VectorXd& x) const {
  for (int j = first; j < end; ++j) x[dof_of_[static_cast<std::size_t>(j)]] = solution_[j];
}

void CondensedFactor::backward(const Eigen::VectorXd& x_root, Eigen::VectorXd& x) {
  const int unknowns = static_cast<int>(dof_of_.size());
  solution_.tail(unknowns - interior_) = x_root;
  store(interior_, unknowns, x);
  for (auto top = division_.top.rbegin(); top != division_.top.rend(); ++top) {
    const Block& block = blocks_[static_cast<std::size_t>(*top)];
    scale(block.first, block.end());
    recover_top(block);
    store(block.first, block.end(), x);
  }
  for_each(static_cast<int>(division_.subtrees.size()), [&](int part, int thread) noexcept {
    const Subtrees::Subtree& subtree = division_.subtrees[static_cast<std::size_t>(part)];
    double* y = gathered_.col(thread).data();
    scale(subtree.first_unknown, subtree.end_unknown);
    for (int k = subtree.end_block - 1; k >= subtree.first_block; --k) {
      const Block& block = blocks_[static_cast<std::size_t>(k)];
      gather_below(block, y);
      subtract_transposed_product(rectangle_of(block), block.rows, block.width, y, solution_.data() + block.first);
      solve_own_transposed(block);
    }
    store(subtree.first_unknown, subtree.end_unknown, x);
  });
}

}  // namespace ricochet::implicit_solver
