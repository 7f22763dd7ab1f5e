#include "coupler/report/parts/csv_table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "common/base/error.hpp"
#include "coupler/report/parts/history_table.hpp"

namespace ricochet::report {
namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells{""};
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool doubled = quoted && line.compare(i, 2, "\"\"") == 0;
    if (line[i] == '"' && !doubled) {
      quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
    if (doubled) ++i;
  }
  return cells;
}

}  // namespace

std::vector<CsvRow> read_csv(const std::string& path) {
  std::istringstream text(read_text(path));
  std::vector<std::string> names;
  std::vector<CsvRow> rows;
  std::size_t line_number = 0;
  for (std::string line; std::getline(text, line);) {
    const auto cells = cells_of(line);
    if (++line_number == 1) {
      names = cells;
      continue;
    }
    if (cells.size() != names.size()) {
      throw ConfigError(fmt::format("{}:{}: {} values, but the header names {} columns", path, line_number,
                                    cells.size(), names.size()));
    }
    auto& row = rows.emplace_back();
    for (std::size_t c = 0; c < names.size(); ++c) row[names[c]] = cells[c];
  }
  return rows;
}

std::optional<double> number(const CsvRow& row, const std::string& column) {
  const auto found = row.find(column);
  if (found == row.end()) return {};
  double value = 0.0;
  const char* end = found->second.data() + found->second.size();
  const auto [stop, error] = std::from_chars(found->second.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return {};
  return value;
}

}  // namespace ricochet::report
