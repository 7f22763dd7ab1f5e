#include "implicit_solver/condensed_factor.hpp"

#include <cholmod.h>

#include <Eigen/Cholesky>
#include <memory>
#include <string>

#include "common/base/error.hpp"

namespace ricochet::implicit_solver {
namespace {

/// CHOLMOD's workspace and the objects that must go back to it.
struct Cholmod {
  cholmod_common common{};
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;
  Cholmod() { cholmod_start(&common); }
  ~Cholmod() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
};

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

[[noreturn]] void refuse_indefinite() {
  throw SolverError("the implicit operator M + dt^2/4 K is not positive definite: check materials and supports of the "
                    "implicit partition");
}

/// Fill-reducing order that keeps the root unknowns last.
std::vector<int> constrained_order(cholmod_sparse* matrix, const std::vector<int>& group, cholmod_common& common) {
  std::vector<int> order(group.size());
  std::vector<int> members = group;
  if (!cholmod_camd(matrix, nullptr, 0, members.data(), order.data(), &common)) {
    throw SolverError("CHOLMOD could not order the implicit operator (out of memory?)");
  }
  return order;
}

}  // namespace

CondensedFactor::CondensedFactor(const fem::SparseMatrix& a, const std::vector<bool>& active, const std::vector<int>& root) {
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
  common.postorder = 0;  // postordering would move the root
  common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod.matrix = upper_triangle(a, unknown_of, unknowns, common);

  std::vector<int> group(static_cast<std::size_t>(unknowns), 0);
  for (const int dof : root) group[static_cast<std::size_t>(unknown_of[static_cast<std::size_t>(dof)])] = 1;
  std::vector<int> order = constrained_order(cholmod.matrix, group, common);
  for (int k = 0; k < roots; ++k) {  // the root in the caller's order
    order[static_cast<std::size_t>(interior_ + k)] = unknown_of[static_cast<std::size_t>(root[static_cast<std::size_t>(k)])];
  }
  cholmod.factor = cholmod_analyze_p(cholmod.matrix, order.data(), nullptr, 0, &common);
  cholmod_factorize(cholmod.matrix, cholmod.factor, &common);
  if (common.status != CHOLMOD_OK || cholmod.factor->minor < cholmod.factor->n) refuse_indefinite();
  cholmod_change_factor(CHOLMOD_REAL, 0, 0, 1, 1, cholmod.factor, &common);

  const auto* start = static_cast<const int*>(cholmod.factor->p);
  const auto* rows = static_cast<const int*>(cholmod.factor->i);
  const auto* values = static_cast<const double*>(cholmod.factor->x);
  for (int j = 0; j < unknowns; ++j) {  // L D L^T exists for indefinite matrices, too
    if (!(values[start[j]] > 0.0)) refuse_indefinite();
  }
  column_.push_back(0);
  for (int j = 0; j < interior_; ++j) {
    diagonal_.push_back(values[start[j]]);
    row_.insert(row_.end(), rows + start[j] + 1, rows + start[j + 1]);
    values_.insert(values_.end(), values + start[j] + 1, values + start[j + 1]);
    column_.push_back(static_cast<int>(row_.size()));
  }
  for (const int unknown : order) dof_of_.push_back(dof_of_unknown[static_cast<std::size_t>(unknown)]);

  Eigen::MatrixXd lower = Eigen::MatrixXd::Identity(roots, roots);
  Eigen::VectorXd pivots(roots);
  for (int k = 0; k < roots; ++k) {
    const int j = interior_ + k;
    pivots[k] = values[start[j]];
    for (int p = start[j] + 1; p < start[j + 1]; ++p) lower(rows[p] - interior_, k) = values[p];
  }
  const Eigen::MatrixXd half = lower.triangularView<Eigen::UnitLower>().solve(Eigen::MatrixXd::Identity(roots, roots));
  root_inverse_ = half.transpose() * pivots.cwiseInverse().asDiagonal() * half;
  work_.setZero(unknowns);
  root_rhs_.setZero(roots);
}

void CondensedFactor::forward(const Eigen::VectorXd& b) {
  const int unknowns = static_cast<int>(dof_of_.size());
  for (int j = 0; j < unknowns; ++j) work_[j] = b[dof_of_[static_cast<std::size_t>(j)]];
  double* x = work_.data();
  for (int j = 0; j < interior_; ++j) {
    const double xj = x[j];
    const int end = column_[static_cast<std::size_t>(j) + 1];
    for (int p = column_[static_cast<std::size_t>(j)]; p < end; ++p) {
      x[row_[static_cast<std::size_t>(p)]] -= values_[static_cast<std::size_t>(p)] * xj;
    }
  }
  root_rhs_ = work_.tail(unknowns - interior_);
}

void CondensedFactor::backward(const Eigen::VectorXd& x_root, Eigen::VectorXd& x) {
  const int unknowns = static_cast<int>(dof_of_.size());
  solution_ = work_;  // what `forward` left may be used again
  solution_.tail(unknowns - interior_) = x_root;
  double* w = solution_.data();
  for (int j = interior_ - 1; j >= 0; --j) {
    double sum = w[j] / diagonal_[static_cast<std::size_t>(j)];
    const int end = column_[static_cast<std::size_t>(j) + 1];
    for (int p = column_[static_cast<std::size_t>(j)]; p < end; ++p) {
      sum -= values_[static_cast<std::size_t>(p)] * w[row_[static_cast<std::size_t>(p)]];
    }
    w[j] = sum;
  }
  for (int j = 0; j < unknowns; ++j) x[dof_of_[static_cast<std::size_t>(j)]] = w[j];
}

}  // namespace ricochet::implicit_solver
