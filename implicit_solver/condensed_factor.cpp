#include "implicit_solver/condensed_factor.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "implicit_solver/cholmod_objects.hpp"
#include "implicit_solver/panels.hpp"

namespace ricochet::implicit_solver {
namespace {

/// Speed of CHOLMOD's dense blocks and of what follows, in operations that CHOLMOD counts: to tell how far a
/// factorisation is, not how long it takes.
constexpr double flops_per_s = 6e9, arranged_flops_per_s = 2e10;
/// Entries of a block that are worth a thread.
constexpr double least_entries_of_part = 1e4;

/// Where part `part` of `parts` of so many begins.
int share(int of, int part, int parts) { return static_cast<int>(std::int64_t{of} * part / parts); }

}  // namespace

CondensedFactor::CondensedFactor(fem::SparseMatrix a, const std::vector<bool>& active, const std::vector<int>& root,
                                 std::shared_ptr<Parallel> parallel, participant::Heartbeat* heart)
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
  const auto begins = [heart](const char* doing, double expected_s) {
    if (heart) heart->begin(doing, expected_s);
  };
  begins("ordering", 0.0);
  const EliminationOrder plan = elimination_order(cholmod.matrix, root_unknowns, common);
  std::vector<int> order = plan.order;
  common.supernodal = CHOLMOD_SUPERNODAL;
  cholmod.factor = cholmod_analyze_p(cholmod.matrix, order.data(), nullptr, 0, &common);
  if (!cholmod.factor) refuse_cholmod(common, "analyse");
  begins("factorising", common.fl / flops_per_s);
  if (!cholmod_factorize(cholmod.matrix, cholmod.factor, &common)) refuse_cholmod(common, "factorise");
  if (common.status != CHOLMOD_OK || cholmod.factor->minor < cholmod.factor->n) refuse_indefinite();
  cholmod_free_sparse(&cholmod.matrix, &common);

  begins("arranging the factor", common.fl / arranged_flops_per_s);
  const Supernodes factor(*cholmod.factor);
  for (int j = 0; j < interior_; ++j) inverse_diagonal_.push_back(1.0 / (factor.diagonal(j) * factor.diagonal(j)));
  for (const int unknown : order) dof_of_.push_back(dof_of_unknown[static_cast<std::size_t>(unknown)]);
  collect_blocks(plan.blocks, factor);
  division_ = divide(blocks_, row_, interior_);
  collect_targets();
  int widest = 0, tallest = 0;
  for (const Block& block : blocks_) {
    widest = std::max(widest, block.width);
    tallest = std::max(tallest, padded(block.width + block.rows));
  }
  const int threads = parallel_ ? parallel_->threads() : 1;
  of_rows_.setZero(tallest, threads);
  sums_.setZero(4 * widest, threads);
  own_.setZero(widest);

  invert_root(roots, factor);
  solution_.setZero(unknowns);
  root_rhs_.setZero(roots);
}

/// (L D L^T)^-1 = (D^-1/2 L^-1)^T (D^-1/2 L^-1) of the root's columns.
void CondensedFactor::invert_root(int roots, const Supernodes& factor) {
  Eigen::MatrixXd lower = Eigen::MatrixXd::Identity(roots, roots), half = lower;
  for (int k = 0; k < roots; ++k)
    factor.below_diagonal(interior_ + k, [&](int row, double value) { lower(row - interior_, k) = value; });
  lower.triangularView<Eigen::UnitLower>().solveInPlace(half);
  for (int k = 0; k < roots; ++k) half.row(k) /= factor.diagonal(interior_ + k);
  lower.setZero();
  lower.selfadjointView<Eigen::Lower>().rankUpdate(half.transpose());
  root_inverse_ = lower.selfadjointView<Eigen::Lower>();
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
    room += panel_values(block.width + block.rows, block.width);
    blocks_.push_back(block);
  }
  values_.resize(room);
  std::vector<int> place(dof_of_.size(), 0);
  Eigen::MatrixXd own, columns;
  for (const Block& block : blocks_) {
    for (int k = 0; k < block.rows; ++k)
      place[static_cast<std::size_t>(row_[static_cast<std::size_t>(block.first_row + k)])] = block.width + k;
    columns.setIdentity(block.width + block.rows, block.width);
    for (int c = 0; c < block.width; ++c) {
      factor.below_diagonal(block.first + c, [&](int row, double value) {
        if (value == 0.0) return;
        columns(row < block.end() ? row - block.first : place[static_cast<std::size_t>(row)], c) = value;
      });
    }
    own = columns.topRows(block.width);
    const auto triangle = own.triangularView<Eigen::UnitLower>();
    auto below = columns.bottomRows(block.rows);
    triangle.solveInPlace<Eigen::OnTheRight>(below);
    below *= -1.0;
    auto above = columns.topRows(block.width);
    above.setIdentity();
    triangle.solveInPlace(above);
    store_in_panels(columns, values_.data() + block.values);
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

void CondensedFactor::load(const Eigen::VectorXd& b, int first, int end) {
  for (int j = first; j < end; ++j) work_[j] = b[dof_of_[static_cast<std::size_t>(j)]];
}

/// Eliminates the unknowns `own` of a block, which are in work_, too, as far as panels first ... end - 1 go.
void CondensedFactor::eliminate(const Block& block, int first, int end, const double* own, double* of_rows) {
  const int rows = block.width + block.rows;
  times_panels(values_.data() + block.values, rows, block.width, first, end, own, of_rows);
  double* x = work_.data();
  const int begin = first * panel_rows, stop = std::min(rows, end * panel_rows);
  for (int k = begin; k < std::min(stop, block.width); ++k) x[block.first + k] = of_rows[k];
  const int* target = target_.data() + block.first_row;
  for (int k = std::max(begin, block.width); k < stop; ++k) x[target[k - block.width]] += of_rows[k];
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
      eliminate(block, 0, panels_of(block.width + block.rows), work_.data() + block.first, of_rows_.col(thread).data());
    }
  });
  for (const int k : division_.top) {
    const Block& block = blocks_[static_cast<std::size_t>(k)];
    load(b, block.first, block.end());
  }
  if (!division_.top.empty()) add_from_subtrees();
  for (const int k : division_.top) {
    const Block& block = blocks_[static_cast<std::size_t>(k)];
    own_.head(block.width) = work_.segment(block.first, block.width);
    const int panels = panels_of(block.width + block.rows), parts = std::min(parts_of(block), panels);
    for_each(parts, [&](int part, int thread) noexcept {
      eliminate(block, share(panels, part, parts), share(panels, part + 1, parts), own_.data(),
                of_rows_.col(thread).data());
    });
  }
  root_rhs_ = work_.segment(interior_, unknowns - interior_);
}

/// The operand of `recover`: what `forward` left of a block's unknowns, which may be used again, times D^-1, and what
/// is known of its rows.
void CondensedFactor::gather(const Block& block, double* y) const {
  for (int k = 0; k < block.width; ++k)
    y[k] = work_[block.first + k] * inverse_diagonal_[static_cast<std::size_t>(block.first + k)];
  const int* row = row_.data() + block.first_row;
  for (int k = 0; k < block.rows; ++k) y[block.width + k] = solution_[row[k]];
  std::fill(y + block.width + block.rows, y + padded(block.width + block.rows), 0.0);
}

/// Unknowns first ... end - 1 of a block.
void CondensedFactor::recover(const Block& block, int first, int end, const double* y, int thread) {
  times_transposed_panels(values_.data() + block.values, block.width + block.rows, block.width, first, end, y,
                          solution_.data() + block.first, sums_.col(thread).data());
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
    double* y = of_rows_.col(0).data();
    gather(block, y);
    const int parts = parts_of(block);
    for_each(parts, [&](int part, int thread) noexcept {
      recover(block, share(block.width, part, parts), share(block.width, part + 1, parts), y, thread);
    });
    store(block.first, block.end(), x);
  }
  for_each(static_cast<int>(division_.subtrees.size()), [&](int part, int thread) noexcept {
    const Subtrees::Subtree& subtree = division_.subtrees[static_cast<std::size_t>(part)];
    double* y = of_rows_.col(thread).data();
    for (int k = subtree.end_block - 1; k >= subtree.first_block; --k) {
      const Block& block = blocks_[static_cast<std::size_t>(k)];
      gather(block, y);
      recover(block, 0, block.width, y, thread);
    }
    store(subtree.first_unknown, subtree.end_unknown, x);
  });
}

}  // namespace ricochet::implicit_solver
