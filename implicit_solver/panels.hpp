#pragma once

#include <Eigen/Core>
#include <cstddef>

/// Dense matrices, stored so that a product, or one by the transpose, reads them from the first value to the last: in
/// panels of 16 rows, the last of 4, 8, 12 or 16, with rows of zeros to fill it; of a panel column after column.
namespace ricochet::implicit_solver {

constexpr int panel_rows = 16;

[[nodiscard]] constexpr int panels_of(int rows) { return (rows + panel_rows - 1) / panel_rows; }
/// With the rows that fill the last panel.
[[nodiscard]] constexpr int padded(int rows) { return (rows + 3) / 4 * 4; }
[[nodiscard]] constexpr std::size_t panel_values(int rows, int columns) {
  return static_cast<std::size_t>(padded(rows)) * static_cast<std::size_t>(columns);
}

/// `values`: room for panel_values(matrix.rows(), matrix.cols()).
void store_in_panels(const Eigen::MatrixXd& matrix, double* values);

/// y = A x for the rows of panels first ... end - 1 of A, which has `rows` x `columns`; y, from row 0 on, has
/// padded(rows).
void times_panels(const double* values, int rows, int columns, int first, int end, const double* x, double* y);

/// x = A^T y for the columns first ... end - 1 of A. y has padded(rows), zeros behind its rows; x from column 0 on;
/// `sums`: workspace of 4 columns. How columns are shared out changes no bit.
void times_transposed_panels(const double* values, int rows, int columns, int first, int end, const double* y,
                             double* x, double* sums);

}  // namespace ricochet::implicit_solver
