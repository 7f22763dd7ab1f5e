#include "coupler/report/stability_page/stability_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/libraries.hpp"
#include "coupler/report/parts/text.hpp"

namespace ricochet::report {
namespace {

/// Growths below are drawn like this one, above like 1.
constexpr double least_growth = 1e-6;

/// Borders of cells around ascending centres: halfway between neighbours, the outer ones as far out as in.
std::vector<double> borders(const std::vector<double>& centres, bool logarithmic) {
  const auto forth = [&](double x) { return logarithmic ? std::log(x) : x; };
  const auto back = [&](double x) { return logarithmic ? std::exp(x) : x; };
  const auto between = [&](std::size_t i) { return 0.5 * (forth(centres[i]) + forth(centres[i + 1])); };
  if (centres.size() == 1) return {0.5 * centres[0], 1.5 * centres[0]};
  std::vector<double> result{back(2.0 * forth(centres[0]) - between(0))};
  for (std::size_t i = 0; i + 1 < centres.size(); ++i) result.push_back(back(between(i)));
  result.push_back(back(2.0 * forth(centres.back()) - between(centres.size() - 2)));
  return result;
}

/// The axis of the other parameter: its values as they are, or one place after the other.
struct Columns {
  std::vector<double> centre, border;

  explicit Columns(const StabilityMap& map) : centre(map.against_number) {
    const bool numbers = !centre.empty() && std::is_sorted(centre.begin(), centre.end());
    if (!numbers) centre.clear();
    for (std::size_t i = 0; i < map.against.size() && !numbers; ++i) centre.push_back(static_cast<double>(i + 1));
    border = borders(centre, numbers && map.logarithmic);
  }
};

/// The steps of one column of a map, ascending: bisection adds some where others have none.
std::vector<double> steps_of(const StabilityMap& map, const std::string& contact, std::size_t column) {
  std::set<double> distinct;
  for (const auto& cell : map.cells) {
    if (cell.contact == contact && cell.column == column) distinct.insert(cell.step);
  }
  return {distinct.begin(), distinct.end()};
}

Json rows_of(const StabilityMap& map, const std::string& contact, const Columns& columns) {
  Json rows = Json::array();
  for (const auto& cell : map.cells) {
    if (cell.contact != contact) continue;
    const auto steps = steps_of(map, contact, cell.column);
    const auto step_borders = borders(steps, false);
    const auto at = static_cast<std::size_t>(std::lower_bound(steps.begin(), steps.end(), cell.step) - steps.begin());
    rows.push_back({"point", map.against[cell.column], drawn(columns.border[cell.column]),
                    drawn(columns.border[cell.column + 1]), drawn(cell.step), drawn(step_borders[at]),
                    drawn(step_borders[at + 1]), drawn(cell.stable ? least_growth : cell.growth), cell.stable});
  }
  for (const auto& edge : map.edges) {
    if (edge.contact != contact) continue;
    rows.push_back({edge.kind, map.against[edge.column], drawn(columns.border[edge.column]),
                    drawn(columns.border[edge.column + 1]), drawn(edge.step), nullptr, nullptr, nullptr, nullptr});
  }
  return rows;
}

/// Lowest and highest border of the chart's cells.
Json step_domain(const Json& rows) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& row : rows) {
    if (row[0] != "point") continue;
    low = std::min(low, row[5].get<double>());
    high = std::max(high, row[6].get<double>());
  }
  return {low, high};
}

/// A text in an expression of Vega, whatever it holds.
std::string quoted(const std::string& text) { return Json(text).dump(-1, ' ', true, Json::error_handler_t::replace); }

/// Chooses the label of a column by its place on the axis.
std::string label_expression(const StabilityMap& map, const Columns& columns) {
  std::string text = "''";
  for (std::size_t i = 0; i < map.against.size(); ++i) {
    text = fmt::format("abs(datum.value - {0:.12g}) <= 1e-6 * {0:.12g} ? {1} : {2}", columns.centre[i],
                       quoted(map.against[i]), text);
  }
  return text;
}

Chart chart_of(const StabilityMap& map, const std::string& contact) {
  const Columns columns(map);
  const bool logarithmic = map.logarithmic && columns.centre == map.against_number;
  const int width = std::min(chart_width, 120 + 90 * static_cast<int>(map.against.size()));
  Chart chart;
  chart.id = "stability_" + contact;
  chart.title = "Contact " + contact;
  chart.columns = {"kind", "label", "x0", "x1", "step", "y0", "y1", "growth", "stable"};
  chart.rows = rows_of(map, contact, columns);
  chart.spec =
      fill_json(asset("stability.json"), {{"description", Json(chart.title).dump()},
                                          {"width", std::to_string(width)},
                                          {"against_title", Json(map.against_title).dump()},
                                          {"step_title", Json(map.step_title).dump()},
                                          {"x_scale", logarithmic ? "\"log\"" : "\"linear\""},
                                          {"x_domain", Json({columns.border.front(), columns.border.back()}).dump()},
                                          {"x_values", Json(columns.centre).dump()},
                                          {"x_labels", Json(label_expression(map, columns)).dump()},
                                          {"y_domain", step_domain(chart.rows).dump()},
                                          {"y_format", map.cells.front().step < 1e-3 ? "\".3~e\"" : "\".3~f\""},
                                          {"growth_domain", Json({least_growth, 1.0}).dump()}});
  return chart;
}

}  // namespace

std::vector<Chart> stability_charts(const StabilityMap& map) {
  std::set<std::string> contacts;
  for (const auto& cell : map.cells) contacts.insert(cell.contact);
  std::vector<Chart> charts;
  for (const auto& contact : contacts) charts.push_back(chart_of(map, contact));
  return charts;
}

std::string stability_page(const StabilityMap& map) {
  std::string figures, json, notes;
  for (const auto& chart : stability_charts(map)) {
    figures += to_html(chart);
    json += (json.empty() ? "" : ",\n") + to_json(chart);
  }
  for (const auto& note : map.notes) notes += "<p>" + escape_html(note) + "</p>\n";
  const std::string title = "Stability of " + map.title;
  return fill_page(asset("page.html"), {{"title", escape_html(title)},
                                        {"style", std::string(asset("page.css"))},
                                        {"header", "<h1>" + escape_html(title) + "</h1>\n"},
                                        {"tables", notes},
                                        {"help", "<p>Point at a map to read values.</p>"},
                                        {"figures", figures},
                                        {"libraries", libraries_html()},
                                        {"charts", inside_script("[" + json + "]")},
                                        {"script", std::string(asset("page.js"))}});
}

}  // namespace ricochet::report
