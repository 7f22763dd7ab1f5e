#include "coupler/report/parts/outliers.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace ricochet::report {

ShownRange shown_range(const std::vector<const std::vector<double>*>& series) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double least = infinity, most = -infinity, low = 0.0, high = 0.0;  // the axis holds zero anyway
  for (const auto* values : series) {
    std::vector<double> sorted;
    std::copy_if(values->begin(), values->end(), std::back_inserter(sorted), [](double x) { return std::isfinite(x); });
    if (sorted.empty()) continue;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t left_out = sorted.size() < 20 ? 0 : std::max<std::size_t>(1, sorted.size() / 200);
    least = std::min(least, sorted.front());
    most = std::max(most, sorted.back());
    low = std::min(low, sorted[left_out]);
    high = std::max(high, sorted[sorted.size() - 1 - left_out]);
  }
  ShownRange range;
  const double length = high - low;
  if (!(length > 0)) return range;
  if (most > high + 0.5 * length) range.high = high + 0.125 * length;
  if (least < low - 0.5 * length) range.low = low - 0.125 * length;
  return range;
}

}  // namespace ricochet::report
