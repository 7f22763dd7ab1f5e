#include "coupler/report/parts/history_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/read_file.hpp"

namespace ricochet::report {
namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const auto comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

void add_row(HistoryTable& table, std::string_view line, const std::string& where) {
  const auto cells = split(line);
  if (cells.size() != table.names.size()) {
    throw ConfigError(
        fmt::format("{}: {} values, but the header names {} columns", where, cells.size(), table.names.size()));
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    double value = 0;
    const char* end = cells[c].data() + cells[c].size();
    const auto [stop, error] = std::from_chars(cells[c].data(), end, value);
    if (error != std::errc() || stop != end) {
      throw ConfigError(fmt::format("{}: \"{}\" in column \"{}\" is not a number", where, cells[c], table.names[c]));
    }
    table.columns[c].push_back(value);
  }
}

}  // namespace

const std::vector<double>* HistoryTable::find(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &columns[static_cast<std::size_t>(found - names.begin())];
}

std::string read_text(const std::string& path) {
  try {
    return read_file(path);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}; is this the results folder of a run?", error.what()));
  }
}

HistoryTable read_history(const std::string& path) {
  const std::string text = read_text(path);
  std::string_view rest = text;
  HistoryTable table;
  for (std::size_t line_number = 1; !rest.empty(); ++line_number) {
    const auto end = rest.find('\n');
    if (end == std::string_view::npos) break;
    const auto line = rest.substr(0, end);
    rest.remove_prefix(end + 1);
    if (line_number == 1) {
      for (const auto name : split(line)) table.names.emplace_back(name);
      table.columns.resize(table.names.size());
    } else {
      add_row(table, line, fmt::format("{}:{}", path, line_number));
    }
  }
  if (table.names.empty() || table.names.front() != "time_s") {
    throw ConfigError(fmt::format("{}:1: the first column must be \"time_s\"", path));
  }
  return table;
}

}  // namespace ricochet::report
