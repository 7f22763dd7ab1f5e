#pragma once

#include <string>
#include <vector>

#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/csv_table.hpp"

namespace ricochet::report {

/// Table of published ratios of calculation times, each beside the same ratios of the study's own medians, of stepping
/// and of whole runs, with the range that the repeats leave to the latter. Empty if the study names none.
[[nodiscard]] std::string times_table(const Json& study, const std::vector<CsvRow>& rows);

}  // namespace ricochet::report
