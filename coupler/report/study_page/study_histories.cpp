#include "coupler/report/study_page/study_histories.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/parts/thinning.hpp"
#include "coupler/report/study_page/study_parts.hpp"

namespace ricochet::report {
namespace {

struct History {
  std::vector<double> time_s, value;
};

std::map<std::string, History> read_histories(const std::string& path) {
  std::map<std::string, History> all;
  for (const auto& row : read_csv(path)) {
    const auto time_s = number(row, "time_s"), value = number(row, "value");
    if (!time_s || !value) continue;
    auto& history = all[row.at("run")];
    history.time_s.push_back(*time_s);
    history.value.push_back(*value);
  }
  return all;
}

/// Folder of the reference of a run.
std::string reference_of(const Json& study, const CsvRow& row) {
  for (const auto& reference : study.at("references")) {
    if (has_settings(row, reference.at("follows"))) return reference.at("run");
  }
  return "";
}

/// Rows (time, value, which line) of one line; none for a run that failed.
void add_line(Chart& chart, const std::map<std::string, History>& histories, const std::string& key, std::size_t line,
              double time_factor) {
  const auto found = histories.find(key);
  if (found == histories.end()) return;
  const auto& [time_s, value] = found->second;
  for (const auto i : thin(time_s, {&value}, panel_width))
    chart.rows.push_back({drawn(time_factor * time_s[i]), drawn(value[i]), line});
}

Chart chart_of(const Json& study, const Panel& panel, const std::map<std::string, History>& histories,
               std::size_t number_of_panel, double latest_s) {
  const auto methods = texts(study, "methods");
  const auto unit = display_unit(latest_s, "s");
  Chart chart;
  chart.id = fmt::format("history_{}", number_of_panel);
  chart.title = panel.title;
  chart.link = "time";
  chart.columns = {"time", "value", "line"};
  add_line(chart, histories, reference_of(study, *panel.rows.front()), methods.size(), unit.factor);
  for (const auto* row : panel.rows) {
    const auto method = std::find(methods.begin(), methods.end(), row->at("method")) - methods.begin();
    add_line(chart, histories, row->at("run"), static_cast<std::size_t>(method), unit.factor);
  }
  auto looks = looks_of(methods);
  looks.colors.push_back("#bbbbbb");
  looks.dashes.push_back({1, 0});
  auto names = methods;
  names.emplace_back("reference");
  const auto title = history_title(study);
  chart.spec =
      fill_json(asset("overlay.json"),
                {{"description", Json(title + ": " + panel.title).dump()},
                 {"width", Json(panel_width).dump()},
                 {"to", drawn(unit.factor * latest_s).dump()},
                 {"name", Json(Json(names).dump() + "[datum.line]").dump()},
                 {"time_title", Json(fmt::format("time [{}]", unit.name)).dump()},
                 {"value_title", Json("stress / " + study.at("histories").at("over_name").get<std::string>()).dump()},
                 {"methods", Json(names).dump()},
                 {"colors", looks.colors.dump()},
                 {"dashes", looks.dashes.dump()}});
  return chart;
}

}  // namespace

std::string history_title(const Json& study) {
  const auto& wanted = study.at("histories");
  return fmt::format("mean {} over {} = {}", words(wanted.at("quantity")), wanted.at("over_name").get<std::string>(),
                     quantity(wanted.at("over_pa").get<double>(), "Pa"));
}

std::vector<Chart> overlaid_histories(const Json& study, const std::vector<CsvRow>& rows, const std::string& folder) {
  std::vector<Chart> charts;
  if (study.at("histories").is_null()) return charts;
  const auto histories = read_histories(folder + "/histories.csv");
  double latest_s = 0.0;
  for (const auto& row : rows) {
    const auto found = histories.find(row.at("run"));
    if (found != histories.end()) latest_s = std::max(latest_s, found->second.time_s.back());
  }
  for (const auto& panel : panels_of(rows, texts(study, "axes"))) {
    auto chart = chart_of(study, panel, histories, charts.size() + 1, latest_s);
    if (!chart.rows.empty()) charts.push_back(std::move(chart));
  }
  return charts;
}

std::string rms_table(const Json& study, const std::vector<CsvRow>& rows) {
  if (study.at("histories").is_null()) return "";
  const auto methods = texts(study, "methods");
  const auto compared = study.at("histories").at("compare_to").get<std::string>();
  std::string text = fmt::format(
      "<h2>RMS of the difference of the {}</h2>\n<p>From {} at the same settings, over its contact period; in "
      "brackets from the reference, over that of the reference.</p>\n<table>\n<thead><tr><th></th>",
      escape_html(history_title(study)), escape_html(compared));
  for (const auto& method : methods) text += cell("th", method);
  text += "</tr></thead>\n<tbody>\n";
  const auto shown = [](const std::optional<double>& value) { return value ? fmt::format("{:.4f}", *value) : "–"; };
  for (const auto& panel : panels_of(rows, texts(study, "axes"))) {
    text += "<tr>" + cell("td", panel.title);
    for (const auto* row : panel.rows)
      text +=
          cell("td", fmt::format("{} ({})", shown(number(*row, "rms_compared")), shown(number(*row, "rms_reference"))));
    text += "</tr>\n";
  }
  return text + "</tbody>\n</table>\n";
}

}  // namespace ricochet::report
