#pragma once

#include <vector>

#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/history_table.hpp"

namespace ricochet::report {

/// The charts of charts/charts.json over time, in its order. Left out are series whose column does not exist or is
/// nowhere above 1e-9 of the chart's largest value, and charts without series.
///
/// An entry of charts.json: id, title, note (optional), template (a file beside it), unit (SI; the display prefix is
/// chosen by the largest value), y_title, series: [{column, label, color (optional)}]. A `*` in a column stands for any
/// text, one series for each match; a `*` in the label for the same text. A new chart needs no other place.
///
/// `events_s`: times that every chart marks.
[[nodiscard]] std::vector<Chart> history_charts(const HistoryTable& table, const std::vector<double>& events_s);

/// The same by charts/probe_charts.json, of the table probes.csv.
[[nodiscard]] std::vector<Chart> probe_charts(const HistoryTable& table, const std::vector<double>& events_s);

}  // namespace ricochet::report
