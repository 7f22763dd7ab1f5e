#pragma once

#include <cholmod.h>

#include <cstddef>
#include <vector>

#include "common/fem/part.hpp"

namespace ricochet::implicit_solver {

/// CHOLMOD's workspace and the objects that must go back to it.
struct Cholmod {
  cholmod_common common{};
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;
  Cholmod();
  ~Cholmod();
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
};

[[noreturn]] void refuse_indefinite();
/// CHOLMOD's calls return nothing then: the machine's failure, as any other lack of memory, and no fault of the scene.
[[noreturn]] void refuse_cholmod(const cholmod_common& common, const char* could_not);

/// Upper triangle of the active rows and columns of A, in CHOLMOD's column form.
[[nodiscard]] cholmod_sparse* upper_triangle(const fem::SparseMatrix& a, const std::vector<int>& unknown_of,
                                             int unknowns, cholmod_common& common);

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

  /// The diagonal of L in L L^T.
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

}  // namespace ricochet::implicit_solver
