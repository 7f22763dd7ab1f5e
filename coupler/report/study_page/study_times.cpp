#include "coupler/report/study_page/study_times.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/vocabulary.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/study_page/study_parts.hpp"

namespace ricochet::report {
namespace {

/// column of one run over column_over of the other one.
std::string ratio(const CsvRow& row, const CsvRow& over, const std::string& column, const std::string& column_over) {
  const auto a = number(row, column), b = number(over, column_over);
  return a && b && *b > 0.0 ? fmt::format("{:.3f}", *a / *b) : "–";
}

std::string line_of(const Json& published, const Panel& panel, const CsvRow& row, const CsvRow& over) {
  const auto wall = ratio(row, over, "wall_s", "wall_s"), least = ratio(row, over, "wall_min_s", "wall_max_s"),
             most = ratio(row, over, "wall_max_s", "wall_min_s");
  std::string text = "<tr>";
  text += cell("td", row.at("method")) + cell("td", over.at("method")) + cell("td", panel.title);
  text += cell("td", fmt::format("{:.3f}", published.at("time_ratio").get<double>()));
  text += cell("td", ratio(row, over, "stepping_s", "stepping_s"));
  text += cell("td", fmt::format("{} ({} to {})", wall, least, most));
  return text + cell("td", published.at("source").get<std::string>()) + "</tr>\n";
}

const CsvRow* run_of(const Panel& panel, const std::string& method) {
  const auto found = std::find_if(panel.rows.begin(), panel.rows.end(),
                                  [&](const CsvRow* row) { return row->at("method") == method; });
  return found == panel.rows.end() || (*found)->at("status") != name_of(RunStatus::done) ? nullptr : *found;
}

std::string lines_of(const Json& published, const std::vector<Panel>& panels) {
  std::string text;
  for (const auto& panel : panels) {
    const auto* over = run_of(panel, published.at("over"));
    if (over == nullptr || !has_settings(*over, published.at("at"))) continue;
    for (const auto& method : published.at("methods").get<std::vector<std::string>>()) {
      if (const auto* row = run_of(panel, method)) text += line_of(published, panel, *row, *over);
    }
  }
  return text;
}

}  // namespace

std::string times_table(const Json& study, const std::vector<CsvRow>& rows) {
  const auto panels = panels_of(rows, texts(study, "axes"));
  std::string text;
  for (const auto& published : study.at("published")) text += lines_of(published, panels);
  if (text.empty()) return "";
  return "<h2>Calculation times beside published ones</h2>\n<p>Ratios of medians; in brackets the smallest and the "
         "largest "
         "ratio that the repeats allow.</p>\n<table>\n<thead><tr><th>method</th><th>over</th><th>settings</th>"
         "<th>published</th><th>stepping</th><th>whole run</th><th>source</th></tr></thead>\n<tbody>\n" +
         text + "</tbody>\n</table>\n";
}

}  // namespace ricochet::report
