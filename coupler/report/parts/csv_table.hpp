#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ricochet::report {

/// Line of a CSV file by the names of its header.
using CsvRow = std::map<std::string, std::string>;

/// Cells may be quoted, "" within them is a quote; no line breaks within cells. ConfigError naming file and line where
/// a line has more or fewer cells than the header.
[[nodiscard]] std::vector<CsvRow> read_csv(const std::string& path);

/// Empty for an empty cell and for one that is no finite number.
[[nodiscard]] std::optional<double> number(const CsvRow& row, const std::string& column);

}  // namespace ricochet::report
