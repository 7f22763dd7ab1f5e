#include "coupler/report/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/own_files.hpp"
#include "common/base/write_file.hpp"
#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/parts/libraries.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/run_page/history_charts.hpp"
#include "coupler/report/run_page/stress_waves.hpp"
#include "coupler/report/run_page/summary_page.hpp"
#include "coupler/report/run_page/timeline.hpp"
#include "coupler/report/shapes/shape_viewer.hpp"
#include "coupler/report/stability_page/stability_maps.hpp"
#include "coupler/report/stability_page/stability_page.hpp"
#include "coupler/report/study_page/study_page.hpp"

namespace ricochet::report {
namespace {

struct Event {
  std::string name;
  double time_s = 0;
};

std::vector<Event> events_of(const Json& summary) {
  std::vector<Event> events;
  if (const auto first = number(summary, "first_contact_s")) events.push_back({"first contact", *first});
  if (const auto separation = number(summary, "separation_time_s")) events.push_back({"separation", *separation});
  for (const auto& departed : summary.value("outside_model", Json::array())) {
    const std::string kind = departed.value("kind", "");
    const auto time = number(departed, "first_s");
    if (time && (kind == "yield" || kind == "tension"))
      events.push_back(
          {(kind == "yield" ? "yield stress passed in " : "strength passed in ") + departed.value("body", ""), *time});
  }
  for (const auto& change : summary.value("switches", Json::array())) {
    if (const auto time = number(change, "time_s")) events.push_back({"switch of integration", *time});
  }
  return events;
}

/// Column theory_contact_stress_pa: the stress of impedance theory until the first wave comes back to the contact.
void add_theory(HistoryTable& table, const Json& summary) {
  const auto first = number(summary, "first_contact_s");
  const Json theory = summary.value("theory", Json());
  if (!first || theory.is_null()) return;
  const double end_s = *first + number(theory, "first_step_s").value_or(0.0);
  const double stress_pa = number(theory, "contact_stress_pa").value_or(0.0);
  std::vector<double> values;
  for (const double time : table.columns.front()) {
    values.push_back(*first <= time && time <= end_s ? stress_pa : std::numeric_limits<double>::quiet_NaN());
  }
  table.names.emplace_back("theory_contact_stress_pa");
  table.columns.push_back(std::move(values));
}

/// Columns yield_stress_pa/BODY, the same at all times. A line far above all stresses would press them to the axis.
void add_limits(HistoryTable& table, const Json& summary) {
  constexpr double far = 3.0;
  double largest_pa = 0.0;
  for (const char* name : {"contact_pressure_mean_pa", "contact_pressure_max_pa", "principal_stress_mean_pa"}) {
    const auto* column = table.find(name);
    if (!column) continue;
    for (const double value : *column) largest_pa = std::max(largest_pa, std::isfinite(value) ? value : 0.0);
  }
  for (const auto& limit : summary.value("limits", Json::array())) {
    const auto yield_pa = number(limit, "yield_stress_pa");
    if (!yield_pa || *yield_pa > far * largest_pa) continue;
    table.names.push_back("yield_stress_pa/" + limit.value("body", ""));
    table.columns.emplace_back(table.rows(), *yield_pa);
  }
}

/// A text on the dotted lines; empty if there are none.
std::string events_text(const std::vector<Event>& events) {
  std::string list, last;
  for (const auto& event : events) {
    list += list.empty() ? "Dotted vertical lines: " : ", ";
    if (event.name != last) list += event.name + " ";
    list += quantity(event.time_s, "s");
    last = event.name;
  }
  return list.empty() ? "" : list + ".";
}

std::string help_html(const HistoryTable& table, const std::vector<Event>& events, const Shapes& shapes) {
  std::string text;
  if (shapes.pieces.empty()) {  // else the picture says who is missing
    for (const auto& missing : shapes.missing) text += "<p>" + escape_html(missing) + "</p>";
  }
  if (table.rows() < 2) return text + "<p>The run ended before there was a history to draw.</p>";
  text +=
      "<p>Point at a chart to read values. Drag over a stretch of time to enlarge it in all charts over time, "
      "double-click to go back.</p>";
  if (events.empty()) return text;
  return text + "<p>" + escape_html(events_text(events)) + "</p>";
}

std::vector<Chart> charts_of(const std::filesystem::path& folder, const HistoryTable& table,
                             const std::vector<Event>& events) {
  std::vector<double> times;
  for (const auto& event : events) times.push_back(event.time_s);
  auto charts = history_charts(table, times);
  const auto axial = folder / "axial_stress.csv";
  if (table.rows() > 1 && std::filesystem::exists(axial)) {
    const auto& time = table.columns.front();
    auto waves = stress_wave_charts(read_history(axial.string()), {time.front(), time.back(), times});
    const auto after =
        charts.begin() + std::min<std::ptrdiff_t>(1, std::ssize(charts));  // beside the stress at the contact
    charts.insert(after, std::make_move_iterator(waves.begin()), std::make_move_iterator(waves.end()));
  }
  if (const auto probes = folder / "probes.csv"; std::filesystem::exists(probes)) {
    auto seen = probe_charts(read_history(probes.string()), times);
    charts.insert(charts.end(), std::make_move_iterator(seen.begin()), std::make_move_iterator(seen.end()));
  }
  for (auto& chart : charts) chart.caption = events_text(events);
  // A run that was killed has written no trace; the rest of the page is worth having all the same.
  const auto trace = folder / "trace.json";
  if (std::filesystem::exists(trace)) {
    if (auto chart = timeline(read_text(trace.string()))) charts.push_back(std::move(*chart));
  }
  for (auto& map : stability_maps(folder)) charts.push_back(std::move(map));
  return charts;
}

std::string page_of(const std::filesystem::path& folder) {
  const auto summary = read_summary((folder / "summary.json").string());
  auto table = read_history((folder / "history.csv").string());
  add_theory(table, summary);
  add_limits(table, summary);
  const auto events = events_of(summary);
  const auto shapes = read_shapes(folder.string(), summary);
  const auto charts = charts_of(folder, table, events);
  const double first_contact_s = number(summary, "first_contact_s").value_or(std::numeric_limits<double>::quiet_NaN());
  const auto viewer = shape_viewer(shapes, table, first_contact_s);
  std::string figures = viewer ? viewer->html : "", json;  // first of all: what happened
  for (const auto& chart : charts) {
    figures += to_html(chart);
    json += (json.empty() ? "" : ",\n") + to_json(chart);
  }
  return fill_page(asset("page.html"), {{"title", escape_html(scene_name(summary))},
                                        {"style", std::string(asset("page.css"))},
                                        {"header", header_html(summary)},
                                        {"tables", tables_html(summary)},
                                        {"help", help_html(table, events, shapes)},
                                        {"figures", figures},
                                        {"libraries", libraries_html() + (viewer ? viewer->scripts : "")},
                                        {"charts", inside_script("[" + json + "]")},
                                        {"script", std::string(asset("page.js"))}});
}

}  // namespace

Page write_report(const std::string& directory) {
  const std::filesystem::path folder(directory);
  const bool stability =
      !std::filesystem::exists(folder / "summary.json") && std::filesystem::exists(folder / "stability.json");
  Page page;
  try {
    if (std::filesystem::exists(folder / "study.json")) {
      page = {"report.html", study_page(directory)};
    } else if (stability) {
      page = {"stability.html", stability_page(read_stability_map((folder / "stability.json").string()))};
    } else {
      page = {"report.html", page_of(directory)};
    }
  } catch (const Json::exception& error) {
    throw ConfigError(
        fmt::format("{}: summary.json, trace.json, fields/*.shapes.json or study.json is not that of this program: {}",
                    directory, error.what()));
  }
  OwnFiles own(directory);
  own.claim({page.path});
  page.path = (folder / page.path).string();
  write_atomically(page.path, page.text);
  return page;
}

}  // namespace ricochet::report
