#pragma once

#include <string>
#include <vector>

#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/csv_table.hpp"

namespace ricochet::report {

/// The histories of a study's histories.csv, one chart for all methods with the same settings, the reference behind
/// them. None if the study asks for none.
[[nodiscard]] std::vector<Chart> overlaid_histories(const Json& study, const std::vector<CsvRow>& rows,
                                                    const std::string& folder);

/// Table of the RMS differences of these histories: settings down, methods across.
[[nodiscard]] std::string rms_table(const Json& study, const std::vector<CsvRow>& rows);

/// "mean principal stress over sigma_0 = 608 MPa"
[[nodiscard]] std::string history_title(const Json& study);

}  // namespace ricochet::report
