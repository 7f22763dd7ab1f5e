#include "coupler/report/run_page/history_charts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/outliers.hpp"
#include "coupler/report/parts/quantity.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/parts/thinning.hpp"

namespace ricochet::report {
namespace {

struct Series {
  std::string label, color;
  std::vector<int> dash;
  const std::vector<double>* values = nullptr;
};

/// Colours of Okabe and Ito (2008), told apart by colour-blind eyes; the dashes tell them apart in black and white.
const std::vector<std::pair<std::string, std::vector<int>>>& styles() {
  static const std::vector<std::pair<std::string, std::vector<int>>> table = {
      {"#0072B2", {1, 0}},        {"#D55E00", {7, 3}},       {"#000000", {2, 2}}, {"#009E73", {9, 3, 2, 3}},
      {"#CC79A7", {12, 3, 4, 3}}, {"#E69F00", {4, 2, 1, 2}}, {"#56B4E9", {14, 4}}};
  return table;
}

double largest(const std::vector<double>& values) {
  double found = 0;
  for (const double value : values) {
    if (std::isfinite(value)) found = std::max(found, std::abs(value));
  }
  return found;
}

/// Finds what the `*` of `pattern` stands for in `name`; false if the name does not match.
bool matches(const std::string& pattern, const std::string& name, std::string& star) {
  const auto at = pattern.find('*');
  if (at == std::string::npos) return pattern == name;
  const auto tail = pattern.size() - at - 1;
  if (name.size() < at + tail || name.compare(0, at, pattern, 0, at) != 0) return false;
  if (name.compare(name.size() - tail, tail, pattern, at + 1, tail) != 0) return false;
  star = name.substr(at, name.size() - at - tail);
  return true;
}

std::vector<Series> series_of(const Json& entry, const HistoryTable& table) {
  std::vector<Series> all;
  double most = 0;
  for (const auto& wanted : entry.at("series")) {
    for (std::size_t c = 0; c < table.names.size(); ++c) {
      std::string star;
      if (!matches(wanted.at("column"), table.names[c], star)) continue;
      Series series{wanted.at("label"), wanted.value("color", ""), {}, &table.columns[c]};
      if (const auto at = series.label.find('*'); at != std::string::npos) series.label.replace(at, 1, star);
      most = std::max(most, largest(*series.values));
      all.push_back(std::move(series));
    }
  }
  std::vector<Series> shown;
  for (auto& series : all) {
    const double most_of_it = largest(*series.values);
    if (most_of_it == 0 || most_of_it <= 1e-9 * most) continue;
    const auto& [color, dash] = styles()[shown.size() % styles().size()];
    if (series.color.empty()) series.color = color;
    series.dash = dash;
    shown.push_back(std::move(series));
  }
  return shown;
}

std::string titled(const std::string& title, const std::string& unit) {
  return unit.empty() ? title : fmt::format("{} [{}]", title, unit);
}

/// A Vega expression that turns the field names c0, c1, ... of the legend into the labels.
std::string legend(const Json& labels) { return fmt::format("({})[datum.label]", labels.dump()); }

/// Below `rounding`, in SI units, a value is drawn as 0, or -1e-20 would give the axis a negative part.
void add_rows(Chart& chart, const std::vector<Series>& shown, const std::vector<double>& time, double time_factor,
              double factor, double rounding) {
  std::vector<const std::vector<double>*> values;
  for (const auto& series : shown) values.push_back(series.values);
  const auto kept = thin(time, values, chart_width);
  for (const auto row : kept) {
    Json cells = {drawn(time_factor * time[row])};
    for (const auto* column : values) {
      const double value = (*column)[row];
      cells.push_back(drawn(std::abs(value) <= rounding ? 0.0 : factor * value));
    }
    chart.rows.push_back(std::move(cells));
  }
  if (kept.size() == time.size()) return;
  chart.note +=
      fmt::format("{}Drawn from {} of {} rows: the first, last, smallest and largest value of every pixel column.",
                  chart.note.empty() ? "" : " ", kept.size(), time.size());
}

/// All that is the same in all charts over this time axis.
struct TimeAxis {
  DisplayUnit unit;
  double from = 0, to = 0;
  Json events = Json::array();
};

TimeAxis time_axis(const std::vector<double>& time, const std::vector<double>& events_s) {
  TimeAxis axis;
  axis.unit = display_unit(time.back(), "s");
  axis.from = axis.unit.factor * time.front();
  axis.to = axis.unit.factor * time.back();
  for (const double event : events_s) axis.events.push_back({{"time", drawn(axis.unit.factor * event)}});
  return axis;
}

/// The extreme value of every series beyond the range that a chart shows at first: marked at its edge, told in the
/// note.
Json beyond(Chart& chart, const std::vector<Series>& shown, const std::vector<double>& time, const ShownRange& range,
            const TimeAxis& axis, const std::string& si_unit) {
  Json marks = Json::array();
  for (const auto& series : shown) {
    const auto& values = *series.values;
    std::vector<std::size_t> extremes;
    for (std::size_t row = 0; row < values.size(); ++row) {
      if (!std::isfinite(values[row]) || range.holds(values[row])) continue;
      const auto same_side = std::find_if(extremes.begin(), extremes.end(), [&](std::size_t other) {
        return (values[other] > range.high) == (values[row] > range.high);
      });
      if (same_side == extremes.end()) {
        extremes.push_back(row);
      } else if (std::abs(values[row]) > std::abs(values[*same_side])) {
        *same_side = row;
      }
    }
    for (const auto row : extremes) {
      const bool up = values[row] > range.high, left = time[row] < 0.5 * (time.front() + time.back());
      const auto value = quantity(values[row], si_unit, 4);
      const std::string arrow = up ? "▲" : "▼";
      marks.push_back({{"time", drawn(axis.unit.factor * time[row])},
                       {"up", up},
                       {"align", left ? "left" : "right"},
                       {"label", left ? arrow + " " + value : value + " " + arrow}});
      chart.note += fmt::format("{}Beyond the axis {}: {} reaches {} at {}; enlarge that time to see it whole.",
                                chart.note.empty() ? "" : " ", arrow, series.label, value, quantity(time[row], "s", 4));
    }
  }
  return marks;
}

/// A Vega expression for what is drawn of a value: itself in an enlarged chart, else the nearest value in the range.
std::string shown_value(const ShownRange& range, double factor, const std::string& whole) {
  std::string value = "datum.value";
  if (std::isfinite(range.high)) value = fmt::format("min({}, {:.6g})", value, factor * range.high);
  if (std::isfinite(range.low)) value = fmt::format("max({}, {:.6g})", value, factor * range.low);
  if (value == "datum.value") return value;
  return fmt::format("({}) && isValid(datum.value) ? {} : datum.value", whole, value);
}

Chart make_chart(const Json& entry, const std::vector<Series>& shown, const std::vector<double>& time,
                 const TimeAxis& axis) {
  double most = 0;
  for (const auto& series : shown) most = std::max(most, largest(*series.values));
  const auto unit = display_unit(most, entry.at("unit"));
  const std::string time_title = titled("time", axis.unit.name);
  Chart chart;
  chart.id = entry.at("id");
  chart.title = entry.at("title");
  chart.note = entry.value("note", "");
  chart.link = "time";
  chart.columns = {"time"};
  Json fields = Json::array(), colors = Json::array(), dashes = Json::array(), labels = Json::object();
  Json tooltip = {{{"field", "time"}, {"title", time_title}, {"format", ".5~g"}}};
  for (const auto& series : shown) {
    const std::string field = fmt::format("c{}", chart.columns.size() - 1);
    chart.columns.push_back(field);
    fields.push_back(field);
    colors.push_back(series.color);
    dashes.push_back(series.dash);
    labels[field] = series.label;
    tooltip.push_back({{"field", field}, {"title", titled(series.label, unit.name)}, {"format", ".5~g"}});
  }
  add_rows(chart, shown, time, axis.unit.factor, unit.factor, 1e-9 * most);
  std::vector<const std::vector<double>*> values;
  for (const auto& series : shown) values.push_back(series.values);
  const auto range = entry.at("template") == "lines" ? shown_range(values) : ShownRange{};
  const auto marks = beyond(chart, shown, time, range, axis, entry.at("unit"));
  const std::string whole = fmt::format("from == {} && to == {}", Json(axis.from).dump(), Json(axis.to).dump());
  const std::string y_title = entry.at("y_title");
  chart.spec = fill_json(asset(entry.at("template").get<std::string>() + ".json"),
                         {{"description", Json(chart.title + " over time").dump()},
                          {"width", Json(chart_width).dump()},
                          {"from", Json(axis.from).dump()},
                          {"to", Json(axis.to).dump()},
                          {"time_title", Json(time_title).dump()},
                          {"y_title", Json(titled(y_title, unit.name)).dump()},
                          {"y_format", unit.factor * most < 1e-2 ? "\".3~e\"" : "\".6~g\""},
                          {"events", axis.events.dump()},
                          {"shown", Json(shown_value(range, unit.factor, whole)).dump()},
                          {"beyond", marks.dump()},
                          {"whole", Json(whole + " ? 1 : 0").dump()},
                          {"fields", fields.dump()},
                          {"colors", colors.dump()},
                          {"dashes", dashes.dump()},
                          {"legend", Json(legend(labels)).dump()},
                          {"tooltip", tooltip.dump()}});
  return chart;
}

}  // namespace

namespace {

std::vector<Chart> charts_by(const std::string& list, const HistoryTable& table, const std::vector<double>& events_s) {
  std::vector<Chart> charts;
  if (table.rows() < 2) return charts;  // no line to draw
  const auto& time = table.columns.front();
  const auto axis = time_axis(time, events_s);
  for (const auto& entry : Json::parse(asset(list))) {
    const auto shown = series_of(entry, table);
    if (!shown.empty()) charts.push_back(make_chart(entry, shown, time, axis));
  }
  return charts;
}

}  // namespace

std::vector<Chart> history_charts(const HistoryTable& table, const std::vector<double>& events_s) {
  return charts_by("charts.json", table, events_s);
}

std::vector<Chart> probe_charts(const HistoryTable& table, const std::vector<double>& events_s) {
  return charts_by("probe_charts.json", table, events_s);
}

}  // namespace ricochet::report
