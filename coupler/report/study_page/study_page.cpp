#include "coupler/report/study_page/study_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/vocabulary.hpp"
#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/csv_table.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/parts/libraries.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/study_page/study_along.hpp"
#include "coupler/report/study_page/study_histories.hpp"
#include "coupler/report/study_page/study_parts.hpp"
#include "coupler/report/study_page/study_times.hpp"

namespace ricochet::report {
namespace {

struct CostColumn {
  const char *column, *name, *title;
};
constexpr CostColumn cost_columns[] = {{"wall_s", "wall time", "wall time, median of the repeats [s]"},
                                       {"cpu_s", "CPU time", "CPU time of all processes, median of the repeats [s]"}};

/// The runs that have both a cost and an error > 0, which a logarithmic axis can show.
struct Points {
  std::vector<const CsvRow*> rows;
  std::vector<std::pair<double, double>> at;
};

Points points_of(const std::vector<CsvRow>& rows, const std::string& cost, const std::string& error) {
  Points points;
  for (const auto& row : rows) {
    const auto x = number(row, cost), y = number(row, error);
    if (!x || !y || *x <= 0.0 || *y <= 0.0) continue;
    points.rows.push_back(&row);
    points.at.emplace_back(*x, *y);
  }
  return points;
}

/// Per point: on the front of its own method.
std::vector<bool> front_of_method(const Points& points) {
  std::vector<bool> result(points.at.size());
  for (std::size_t i = 0; i < points.at.size(); ++i) {
    std::vector<std::pair<double, double>> own{points.at[i]};
    for (std::size_t j = 0; j < points.at.size(); ++j) {
      if (j != i && points.rows[j]->at("method") == points.rows[i]->at("method")) own.push_back(points.at[j]);
    }
    result[i] = pareto_front(own)[0];
  }
  return result;
}

/// Columns of the runs that a point shows when it is pointed at, and what they are called.
std::vector<std::pair<std::string, std::string>> shown_columns(const Json& study) {
  std::vector<std::pair<std::string, std::string>> columns{{"method", "method"}};
  for (const auto& key : texts(study, "parameters")) columns.emplace_back(key, key);
  for (const auto& [column, title] : {std::pair{"step_s", "step [s]"},
                                      {"steps", "steps"},
                                      {"wall_s", "wall [s]"},
                                      {"start_s", "start [s]"},
                                      {"setup_s", "set-up [s]"},
                                      {"stepping_s", "stepping [s]"},
                                      {"cpu_s", "CPU [s]"},
                                      {"repeats", "repeats"}}) {
    columns.emplace_back(column, title);
  }
  for (const auto& value : told_values(study)) columns.emplace_back("value_" + value, value);
  return columns;
}

std::string tooltip(const Json& study, const std::string& error_title) {
  Json entries = Json::array();
  const auto columns = shown_columns(study);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    // Field names with dots would mean members of members.
    const std::string field = i == 0 ? "method" : fmt::format("shown{}", i);
    entries.push_back({{"field", field}, {"type", "nominal"}, {"title", columns[i].second}});
  }
  entries.push_back({{"field", "error"}, {"type", "quantitative"}, {"title", error_title}, {"format", ".3~g"}});
  return entries.dump();
}

std::string shown(const CsvRow& row, const std::string& column) {
  const auto value = number(row, column);
  return value ? fmt::format("{:.4g}", *value) : row.at(column);
}

Chart chart_of(const Json& study, const std::vector<CsvRow>& rows, const std::string& quantity,
               const CostColumn& cost) {
  const auto points = points_of(rows, cost.column, "error_" + quantity);
  const auto front = pareto_front(points.at), best = front_of_method(points);
  const auto columns = shown_columns(study);
  Chart chart;
  chart.id = identifier(fmt::format("{}_{}", quantity, cost.column));
  chart.title = fmt::format("Error of the {} against {}", words(quantity), cost.name);
  if (quantity == "energy_drift") chart.title = fmt::format("Energy drift against {}", cost.name);
  chart.caption = "Lines join the best runs of a method; rings on the broad grey line are the Pareto front.";
  chart.columns = {"cost", "error", "front", "best", "method"};
  for (std::size_t i = 1; i < columns.size(); ++i) chart.columns.push_back(fmt::format("shown{}", i));
  for (std::size_t p = 0; p < points.at.size(); ++p) {
    Json row = {drawn(points.at[p].first), drawn(points.at[p].second), bool(front[p]), bool(best[p])};
    for (const auto& [column, title] : columns) row.push_back(shown(*points.rows[p], column));
    chart.rows.push_back(row);
  }
  const auto methods = texts(study, "methods");
  const auto looks = looks_of(methods);
  const std::string error_title = quantity == "energy_drift" ? "energy drift" : "relative error";
  chart.spec = without_empty_layers(
      fill_json(asset("work_precision.json"), {{"description", Json(chart.title).dump()},
                                               {"cost_title", Json(cost.title).dump()},
                                               {"error_title", Json(error_title).dump()},
                                               {"methods", Json(methods).dump()},
                                               {"colors", looks.colors.dump()},
                                               {"shapes", looks.shapes.dump()},
                                               {"dashes", looks.dashes.dump()},
                                               {"reference", reference_rule(study, quantity).dump()},
                                               {"tooltip", tooltip(study, error_title)}}));
  return chart;
}

/// All runs, failed ones with the reason in place of the errors.
std::string runs_table(const Json& study, const std::vector<CsvRow>& rows) {
  const auto columns = shown_columns(study);
  const auto quantities = texts(study, "quantities");
  std::string text = "<h2>Runs</h2>\n<div class=\"runs\">\n<table>\n<thead><tr>";
  for (const auto& [column, title] : columns) text += cell("th", title);
  for (const auto& quantity : quantities) text += cell("th", words(quantity));
  text += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    text += "<tr>";
    for (const auto& [column, title] : columns) text += cell("td", shown(row, column));
    if (row.at("status") == name_of(RunStatus::done)) {
      for (const auto& quantity : quantities) {
        const auto error = number(row, "error_" + quantity);
        text += cell("td", error ? fmt::format("{:.2e}", *error) : "–");
      }
    } else {
      text += fmt::format("<td colspan=\"{}\">{}</td>", quantities.size(),
                          escape_html(row.at("status") + ": " + row.at("error")));
    }
    text += "</tr>\n";
  }
  return text + "</tbody>\n</table>\n</div>\n";
}

std::string errors_of(const Json& reference) {
  std::string text;
  for (const auto& [quantity, error] : reference.at("errors").items()) {
    if (quantity == "energy_drift") continue;
    text += (text.empty() ? "" : ", ") + words(quantity) + " " +
            (error.is_number() ? fmt::format("{:.2g}", error.get<double>()) : std::string("–"));
  }
  return text;
}

std::string head_html(const Json& study) {
  std::string references;
  for (const auto& reference : study.at("references")) {
    references +=
        fmt::format("<dt>reference</dt><dd>{}</dd>\n<dt>its own error</dt><dd>{}</dd>\n",
                    escape_html(reference.at("reference").get<std::string>()), escape_html(errors_of(reference)));
  }
  return fmt::format(
      "<dl><dt>scene</dt><dd>{}</dd>\n{}<dt>repeats</dt><dd>{}, methods taking turns</dd>\n<dt>version</dt>"
      "<dd>ricochet {}</dd></dl>\n",
      escape_html(std::filesystem::path(study.at("scene").get<std::string>()).filename().string()), references,
      study.at("repeats").get<int>(), escape_html(study.at("version").get<std::string>()));
}

std::string work_precision_html(const Json& study, const std::vector<CsvRow>& rows, std::vector<std::string>& json) {
  std::string figures;
  for (const auto& quantity : texts(study, "quantities")) {
    for (const auto& cost : cost_columns) {
      const Chart chart = chart_of(study, rows, quantity, cost);
      if (chart.rows.empty()) continue;
      figures += to_html(chart);
      json.push_back(to_json(chart));
    }
  }
  return figures;
}

std::string histories_html(const Json& study, const std::vector<CsvRow>& rows, const std::string& folder,
                           std::vector<std::string>& json) {
  const auto charts = overlaid_histories(study, rows, folder);
  if (charts.empty()) return "";
  return panels_html(
      "History of the " + history_title(study),
      "Drag over a stretch of time to enlarge it in all of them, double-click to go back. The broad grey "
      "line is the reference.",
      charts, json);
}

std::string page_of(const Json& study, const std::vector<CsvRow>& rows, const std::string& folder) {
  std::vector<std::string> json;
  std::string figures = times_table(study, rows);
  figures += histories_html(study, rows, folder, json);
  figures += rms_table(study, rows);
  figures += along_html(study, rows, json);
  figures += work_precision_html(study, rows, json);
  figures += runs_table(study, rows);
  const std::string title = "Study " + std::filesystem::path(study.at("study").get<std::string>()).stem().string();
  return fill_page(asset("page.html"),
                   {{"title", escape_html(title)},
                    {"style", std::string(asset("page.css"))},
                    {"header", "<h1>" + escape_html(title) + "</h1>\n"},
                    {"tables", head_html(study)},
                    {"help",
                     "<p>Point at a run to read its settings. In charts of error against time lines join the best runs "
                     "of a method; rings on the broad grey line are the Pareto front: no run is both faster and more "
                     "accurate. Left and low is better.</p>"},
                    {"figures", figures},
                    {"libraries", libraries_html()},
                    {"charts", inside_script(fmt::format("[{}]", fmt::join(json, ",\n")))},
                    {"script", std::string(asset("page.js"))}});
}

}  // namespace

std::vector<bool> pareto_front(const std::vector<std::pair<double, double>>& points) {
  std::vector<bool> front;
  for (const auto& [cost, error] : points) {
    front.push_back(std::none_of(points.begin(), points.end(), [cost = cost, error = error](const auto& other) {
      return other.first <= cost && other.second <= error && (other.first < cost || other.second < error);
    }));
  }
  return front;
}

std::string study_page(const std::string& folder) {
  const std::string path = folder + "/study.json";
  try {
    return page_of(Json::parse(read_text(path)), read_csv(folder + "/results.csv"), folder);
  } catch (const Json::exception& error) {
    throw ConfigError(fmt::format("{} is not that of a study: {}", path, error.what()));
  } catch (const std::out_of_range&) {
    throw ConfigError(fmt::format("{}/results.csv lacks a column that {} names", folder, path));
  }
}

}  // namespace ricochet::report
