#pragma once

#include <algorithm>
#include <limits>

namespace ricochet::fem {

/// A stretch of an axis [m]; empty at first.
struct Interval {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  [[nodiscard]] bool empty() const { return low > high; }
  [[nodiscard]] double length() const { return high - low; }
};

}  // namespace ricochet::fem
