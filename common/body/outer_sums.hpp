#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace ricochet::solver {

/// sum a_i b_i^T over the nodes first ... last - 1, where a(i, row) and b(i, column) are the entries of a_i and b_i.
/// Four nodes are summed side by side, in one order on any processor: a sum that waits for the one before it takes
/// three times as long.
template <int rows, int columns, class A, class B>
[[nodiscard]] Eigen::Matrix<double, rows, columns> outer_sums(int first, int last, const A& a, const B& b) {
  constexpr std::size_t lanes = 4;
  using Lanes = std::array<double, lanes>;
  std::array<std::array<Lanes, columns>, rows> sums{};
  const auto add = [&](int from, std::size_t nodes) {
    std::array<Lanes, rows> left{};
    std::array<Lanes, columns> right{};
    for (std::size_t lane = 0; lane < nodes; ++lane) {
      const int node = from + static_cast<int>(lane);
      for (int row = 0; row < rows; ++row) left[static_cast<std::size_t>(row)][lane] = a(node, row);
      for (int column = 0; column < columns; ++column) right[static_cast<std::size_t>(column)][lane] = b(node, column);
    }
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t column = 0; column < columns; ++column)
        for (std::size_t lane = 0; lane < lanes; ++lane)
          sums[row][column][lane] += left[row][lane] * right[column][lane];
  };
  int node = first;
  for (; node + static_cast<int>(lanes) <= last; node += static_cast<int>(lanes)) add(node, lanes);
  add(node, static_cast<std::size_t>(last - node));
  Eigen::Matrix<double, rows, columns> sum;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Lanes& of = sums[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
      sum(row, column) = (of[0] + of[1]) + (of[2] + of[3]);
    }
  }
  return sum;
}

/// sum a_i x b_i from sum a_i b_i^T: of vectors in a plane about the third axis.
[[nodiscard]] inline Eigen::Vector3d turning_part(const Eigen::Matrix3d& sum) {
  return {sum(1, 2) - sum(2, 1), sum(2, 0) - sum(0, 2), sum(0, 1) - sum(1, 0)};
}
[[nodiscard]] inline Eigen::Vector3d turning_part(const Eigen::Matrix2d& sum) {
  return {0.0, 0.0, sum(0, 1) - sum(1, 0)};
}

}  // namespace ricochet::solver
