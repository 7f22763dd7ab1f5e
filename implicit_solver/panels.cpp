#include "implicit_solver/panels.hpp"

#include <algorithm>
#include <cstring>

// Vectors pass between functions of this file only, so how a processor without AVX passes them is nobody's business.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ricochet::implicit_solver {
namespace {

constexpr int lanes = 4;
using Vector = double __attribute__((vector_size(lanes * sizeof(double))));

Vector load(const double* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

void store(const Vector& v, double* to) { std::memcpy(to, &v, sizeof v); }

/// y = A x of a panel of `vectors` x 4 rows. Two sums a row, so that one need not wait for the other.
template <int vectors>
void times(const double* panel, int columns, const double* x, double* y) {
  Vector even[vectors] = {}, odd[vectors] = {};
  int c = 0;
  for (; c + 2 <= columns; c += 2, panel += 2 * vectors * lanes) {
    for (int v = 0; v < vectors; ++v) even[v] += load(panel + v * lanes) * x[c];
    for (int v = 0; v < vectors; ++v) odd[v] += load(panel + (vectors + v) * lanes) * x[c + 1];
  }
  if (c < columns) {
    for (int v = 0; v < vectors; ++v) even[v] += load(panel + v * lanes) * x[c];
  }
  for (int v = 0; v < vectors; ++v) store(even[v] + odd[v], y + v * lanes);
}

/// Four parts of the product of a panel's column with y.
template <int vectors>
Vector column_times(const double* column, const Vector* y) {
  Vector sum = load(column) * y[0];
  for (int v = 1; v < vectors; ++v) sum += load(column + v * lanes) * y[v];
  return sum;
}

template <int vectors>
struct RowsOfPanel {
  Vector y[vectors];
  explicit RowsOfPanel(const double* from) {
    for (int v = 0; v < vectors; ++v) y[v] = load(from + v * lanes);
  }
};

/// Adds what a full panel adds to the four parts of each column's sum.
void add_transposed(const double* panel, int columns, const double* y, double* sums) {
  constexpr int vectors = panel_rows / lanes;
  const RowsOfPanel<vectors> rows(y);
  for (int c = 0; c < columns; ++c, panel += panel_rows, sums += lanes)
    store(load(sums) + column_times<vectors>(panel, rows.y), sums);
}

/// The same of the last panel, and x = the sums of the parts; `only`: it is the first one, too.
template <int vectors, bool only>
void finish_transposed(const double* panel, int columns, const double* y, const double* sums, double* x) {
  const RowsOfPanel<vectors> rows(y);
  const auto parts = [&](int c) {
    const Vector last = column_times<vectors>(panel + c * vectors * lanes, rows.y);
    return only ? last : load(sums + c * lanes) + last;
  };
  int c = 0;
  for (; c + lanes <= columns; c += lanes) {
    const Vector p = parts(c), q = parts(c + 1), r = parts(c + 2), s = parts(c + 3);
    const Vector pq = __builtin_shufflevector(p, q, 0, 4, 2, 6) + __builtin_shufflevector(p, q, 1, 5, 3, 7);
    const Vector rs = __builtin_shufflevector(r, s, 0, 4, 2, 6) + __builtin_shufflevector(r, s, 1, 5, 3, 7);
    store(__builtin_shufflevector(pq, rs, 0, 1, 4, 5) + __builtin_shufflevector(pq, rs, 2, 3, 6, 7), x + c);
  }
  for (; c < columns; ++c) {
    const Vector p = parts(c);
    x[c] = (p[0] + p[1]) + (p[2] + p[3]);
  }
}

/// call.template operator()<vectors>() with the number of vectors of four rows that a panel has.
template <class Call>
void with_vectors(int rows_left, const Call& call) {
  switch (std::min(panel_rows, padded(rows_left)) / lanes) {
    case 1: return call.template operator()<1>();
    case 2: return call.template operator()<2>();
    case 3: return call.template operator()<3>();
    default: return call.template operator()<4>();
  }
}

const double* panel_at(const double* values, int row, int columns) {
  return values + static_cast<std::ptrdiff_t>(row) * columns;
}

}  // namespace

void store_in_panels(const Eigen::MatrixXd& matrix, double* values) {
  const auto rows = static_cast<int>(matrix.rows());
  for (int row = 0; row < rows; row += panel_rows) {
    const int height = std::min(panel_rows, padded(rows) - row);
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
      for (int r = row; r < row + height; ++r) *values++ = r < rows ? matrix(r, c) : 0.0;
    }
  }
}

void times_panels(const double* values, int rows, int columns, int first, int end, const double* x, double* y) {
  for (int row = first * panel_rows; row < std::min(rows, end * panel_rows); row += panel_rows) {
    with_vectors(rows - row,
                 [&]<int vectors>() { times<vectors>(panel_at(values, row, columns), columns, x, y + row); });
  }
}

void times_transposed_panels(const double* values, int rows, int columns, int first, int end, const double* y,
                             double* x, double* sums) {
  const int count = end - first, last = (panels_of(rows) - 1) * panel_rows;
  std::fill(sums, sums + (last == 0 ? 0 : static_cast<std::ptrdiff_t>(lanes) * count), 0.0);
  for (int row = 0; row < last; row += panel_rows)
    add_transposed(panel_at(values, row, columns) + static_cast<std::ptrdiff_t>(first) * panel_rows, count, y + row,
                   sums);
  with_vectors(rows - last, [&]<int vectors>() {
    const double* panel = panel_at(values, last, columns) + static_cast<std::ptrdiff_t>(first) * vectors * lanes;
    if (last == 0) {
      finish_transposed<vectors, true>(panel, count, y, sums, x + first);
    } else {
      finish_transposed<vectors, false>(panel, count, y + last, sums, x + first);
    }
  });
}

}  // namespace ricochet::implicit_solver
