#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/run.hpp"

/// Runs of one scene by different solvers: what differs is the order of sums.
namespace ricochet::test {

/// Largest difference of a column, relative to its largest value, or to one (J, kg m/s, N, ...) where that is smaller:
/// of sums that cancel, rounding is all there is.
inline double column_difference(const RunResult& run, const RunResult& reference, const std::string& column) {
  const auto &a = run.column(column), &b = reference.column(column);
  double scale = 1.0, largest = 0.0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (std::isnan(a[i]) && std::isnan(b[i])) continue;
    scale = std::max(scale, std::abs(b[i]));
    largest = std::max(largest, std::abs(a[i] - b[i]));
  }
  return largest / scale;
}

inline void expect_same_history(const RunResult& run, const RunResult& reference, double tolerance) {
  ASSERT_EQ(run.column("time_s"), reference.column("time_s"));
  for (const auto& [column, values] : reference.history) {
    ASSERT_EQ(run.history.count(column), 1U) << column;
    EXPECT_LE(column_difference(run, reference, column), tolerance) << column;
  }
}

}  // namespace ricochet::test
