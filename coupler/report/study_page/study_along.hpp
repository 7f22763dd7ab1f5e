#pragma once

#include <string>
#include <vector>

#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/csv_table.hpp"

namespace ricochet::report {

/// Charts over the varied key that a study names, a line for each method and a chart for all other settings: every
/// error and RMS difference, stepping time and wall time. Empty if it names none. The charts' JSON goes into `json`.
[[nodiscard]] std::string along_html(const Json& study, const std::vector<CsvRow>& rows,
                                     std::vector<std::string>& json);

}  // namespace ricochet::report
