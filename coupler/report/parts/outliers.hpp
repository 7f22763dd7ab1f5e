#pragma once

#include <limits>
#include <vector>

namespace ricochet::report {

/// Range of an axis for a history whose few largest values are much larger than all others: a contact that closes in
/// one step carries an impulse in one row, beside which everything else would be a flat line.
struct ShownRange {
  double low = -std::numeric_limits<double>::infinity(), high = -low;  ///< infinite: whatever there is

  [[nodiscard]] bool holds(double value) const { return low <= value && value <= high; }
};

/// Per side, over all series: leave out the 0.5 % (at least one) of a series' rows that are farthest out; if the values
/// left out reach more than half of the remaining range, zero included, beyond it, the range shown ends an eighth
/// beyond it. Series of less than 20 finite values are shown whole.
[[nodiscard]] ShownRange shown_range(const std::vector<const std::vector<double>*>& series);

}  // namespace ricochet::report
