#pragma once

#include <string>
#include <vector>

namespace ricochet::report {

/// history.csv by columns. All columns have the same length; values that the run could not give are nan.
struct HistoryTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  /// Null if there is no such column.
  [[nodiscard]] const std::vector<double>* find(const std::string& name) const;
  /// Throws ConfigError naming the column if there is none.
  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
};

/// Text of a whole file. Throws ConfigError naming the file.
[[nodiscard]] std::string read_text(const std::string& path);

/// Reads history.csv. A last line without its end, left by a killed run, is ignored. Throws ConfigError naming file,
/// line and column of what is wrong; also if the first column is not time_s.
[[nodiscard]] HistoryTable read_history(const std::string& path);

}  // namespace ricochet::report
