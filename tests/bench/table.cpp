#include "tests/bench/table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ricochet::bench {
namespace {

double lowest(const Row& row) { return *std::min_element(row.ratios.begin(), row.ratios.end()); }
double highest(const Row& row) { return *std::max_element(row.ratios.begin(), row.ratios.end()); }

std::string level_text(const Row& row) {
  return row.level ? fmt::format("{} {:g}", row.level->at_most ? "<=" : ">=", row.level->value) : "";
}

std::string verdict(const Row& row) {
  if (!row.level) return "";
  const double value = median(row.ratios);
  return (row.level->at_most ? value <= row.level->value : value >= row.level->value) ? "reached" : "missed";
}

}  // namespace

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::vector<double> quotients(const std::vector<double>& numerator, const std::vector<double>& denominator) {
  std::vector<double> result;
  for (std::size_t i = 0; i < numerator.size(); ++i) result.push_back(numerator[i] / denominator.at(i));
  return result;
}

std::string to_text(const std::vector<Row>& rows) {
  std::size_t width = 0;
  for (const auto& row : rows) width = std::max(width, row.quantity.size());
  std::string text =
      fmt::format("{:<{}}  {:<12} {:>10} {:>10} {:>10}  {}\n", "ratio", width, "at", "median", "min", "max", "wanted");
  for (const auto& row : rows) {
    if (row.ratios.empty()) {
      text += fmt::format("{:<{}}  {:<12} {}\n", row.quantity, width, row.at, row.missing);
      continue;
    }
    text += fmt::format("{:<{}}  {:<12} {:>10.4g} {:>10.4g} {:>10.4g}  {} {}\n", row.quantity, width, row.at,
                        median(row.ratios), lowest(row), highest(row), level_text(row), verdict(row));
  }
  return text;
}

std::string to_csv(const std::vector<Row>& rows) {
  std::string text = "ratio,at,median,min,max,repeats,wanted,verdict\n";
  for (const auto& row : rows) {
    if (row.ratios.empty()) {
      text += fmt::format("\"{}\",{},,,,0,{},{}\n", row.quantity, row.at, level_text(row), row.missing);
      continue;
    }
    text += fmt::format("\"{}\",{},{:.6g},{:.6g},{:.6g},{},{},{}\n", row.quantity, row.at, median(row.ratios),
                        lowest(row), highest(row), row.ratios.size(), level_text(row), verdict(row));
  }
  return text;
}

}  // namespace ricochet::bench
