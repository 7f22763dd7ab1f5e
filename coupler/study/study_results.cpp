#include "coupler/study/study_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "coupler/results/csv_cell.hpp"

namespace ricochet::coupler {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

std::vector<double> all_of(const std::vector<Cost>& costs, double Cost::*part) {
  std::vector<double> values;
  for (const auto& cost : costs) values.push_back(cost.*part);
  return values;
}

std::string cell(const std::optional<double>& value) { return value ? fmt::format("{:.6g}", *value) : ""; }

void add_history(std::string& text, const HistoriesSpec& histories, const std::string& key, const Observation& seen) {
  const auto& curve = history_of(histories.quantity, seen);
  for (std::size_t i = 0; i < curve.time_s.size(); ++i)
    text += fmt::format("{},{:.7g},{:.6g}\n", key, curve.time_s[i], curve.value[i] / histories.over_pa);
}

}  // namespace

std::string label_of(const StudyFile& file, const StudyRow& row) {
  std::set<std::string> telling;
  for (const auto& variation : file.variations) {
    const auto keys = telling_keys(variation);
    telling.insert(keys.begin(), keys.end());
  }
  std::string text = row.method;
  for (const auto& setting : row.settings) {
    if (telling.count(setting.key) > 0 && !text_of(setting).empty())
      text += fmt::format(" {}={}", setting.key, text_of(setting));
  }
  return text;
}

std::string to_csv(const StudyFile& file, const std::vector<StudyRow>& rows) {
  std::string text = "method";
  const auto add = [&text](const std::string& value) { text.append(",").append(value); };
  for (const auto& key : varied_keys(file)) add(key);
  text += ",status";
  for (const auto& quantity : file.quantities) add("error_" + quantity);
  for (const auto& name : file.values) add("value_" + name);
  if (file.histories.wanted()) text += ",rms_reference,rms_compared";
  text += ",wall_s,wall_min_s,wall_max_s,start_s,setup_s,stepping_s,cpu_s,repeats,steps,step_s,run,error\n";
  for (const auto& row : rows) {
    text += csv_cell(row.method);
    for (const auto& setting : row.settings) add(csv_cell(text_of(setting)));
    add(row.run.status_text());
    for (const auto& error : row.errors) add(cell(error));
    for (const auto& name : file.values) {
      const auto found = row.values.find(name);
      add(found == row.values.end() ? "" : fmt::format("{:.6g}", found->second));
    }
    if (file.histories.wanted()) text += fmt::format(",{},{}", cell(row.rms_reference), cell(row.rms_compared));
    const auto& costs = row.run.costs();
    if (costs.empty()) {
      text += ",,,,,,,";
    } else {
      const auto wall = all_of(costs, &Cost::wall_s);
      text += fmt::format(",{:.6g},{:.6g},{:.6g}", median(wall), *std::min_element(wall.begin(), wall.end()),
                          *std::max_element(wall.begin(), wall.end()));
      for (const auto part : {&Cost::start_s, &Cost::setup_s, &Cost::stepping_s, &Cost::cpu_s}) {
        text += fmt::format(",{:.6g}", median(all_of(costs, part)));
      }
    }
    text += fmt::format(",{},{},{:.17g},{},{}\n", row.run.repeats(), row.run.steps(), row.run.step_s(), row.run.key(),
                        csv_cell(row.run.error()));
  }
  return text;
}

std::string histories_csv(const StudyFile& file, const std::vector<StudyReference>& references,
                          const std::vector<StudyRow>& rows) {
  std::string text = "run,time_s,value\n";
  std::set<std::string> written;  // several rows may come to the same scene
  for (const auto& reference : references) {
    if (written.insert(reference.key).second) add_history(text, file.histories, reference.key, reference.seen);
  }
  for (const auto& row : rows) {
    if (row.seen && written.insert(row.run.key()).second) add_history(text, file.histories, row.run.key(), *row.seen);
  }
  return text;
}

std::string to_table(const StudyFile& file, const std::vector<StudyRow>& rows) {
  std::size_t width = 6;
  for (const auto& row : rows) width = std::max(width, label_of(file, row).size());
  std::string text = fmt::format("{:<{}} {:>9} {:>9} {:>9}", "run", width, "wall s", "steps s", "CPU s");
  for (const auto& quantity : file.quantities)
    text += fmt::format(" {:>{}}", quantity, std::max<std::size_t>(9, quantity.size()));
  text += "\n";
  for (const auto& row : rows) {
    if (row.run.failed() || row.run.repeats() == 0) {
      text += fmt::format("{:<{}} {}: {}\n", label_of(file, row), width, row.run.status_text(), row.run.error());
      continue;
    }
    const auto& costs = row.run.costs();
    text += fmt::format("{:<{}} {:>9.3f} {:>9.3f} {:>9.3f}", label_of(file, row), width,
                        median(all_of(costs, &Cost::wall_s)), median(all_of(costs, &Cost::stepping_s)),
                        median(all_of(costs, &Cost::cpu_s)));
    for (std::size_t q = 0; q < row.errors.size(); ++q) {
      text += fmt::format(" {:>{}}", row.errors[q] ? fmt::format("{:.2e}", *row.errors[q]) : "-",
                          std::max<std::size_t>(9, file.quantities[q].size()));
    }
    text += "\n";
  }
  return text;
}

}  // namespace ricochet::coupler
