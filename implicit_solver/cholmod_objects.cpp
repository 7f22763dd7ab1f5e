#include "implicit_solver/cholmod_objects.hpp"

#include <algorithm>
#include <new>
#include <string>

#include "common/base/computer.hpp"
#include "common/base/error.hpp"

namespace ricochet::implicit_solver {

Cholmod::Cholmod() {
  use_one_thread_in_cholmod();
  cholmod_start(&common);
  common.print = 0;  // errors are ours to report
}

Cholmod::~Cholmod() {
  cholmod_free_factor(&factor, &common);
  cholmod_free_sparse(&matrix, &common);
  cholmod_finish(&common);
}

void refuse_indefinite() {
  throw SolverError(
      "the implicit operator M + dt^2/4 K is not positive definite: check materials and supports of the "
      "implicit partition");
}

void refuse_cholmod(const cholmod_common& common, const char* could_not) {
  if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  throw SolverError(std::string("CHOLMOD could not ") + could_not + " the implicit operator");
}

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

}  // namespace ricochet::implicit_solver
