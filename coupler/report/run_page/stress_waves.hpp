#pragma once

#include <vector>

#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/history_table.hpp"

namespace ricochet::report {

/// The part that a chart over time shares with the others: its range and the times that it marks [s].
struct TimeRange {
  double from_s = 0, to_s = 0;
  std::vector<double> events_s;
};

/// The x-t diagram of stress waves: mean axial stress over time (to the right) and undeformed axial position (upwards),
/// blue in compression, red and dotted in tension. `table`: axial_stress.csv (see coupler/results/axial_stress.hpp),
/// thinned to at most 200 times and 200 layers. Bodies that lie one behind the other along the axis share a diagram,
/// with the plane between two of them marked; if any overlap, each has one of its own. The colours end at the 99.5th
/// percentile of |stress| if the largest one is more than a quarter beyond it, and the note says so. Empty without two
/// times or without stress. Throws ConfigError for a column that is no layer.
[[nodiscard]] std::vector<Chart> stress_wave_charts(const HistoryTable& table, const TimeRange& range);

}  // namespace ricochet::report
