#include "coupler/report/study_page/study_along.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/text.hpp"
#include "coupler/report/study_page/study_histories.hpp"
#include "coupler/report/study_page/study_parts.hpp"

namespace ricochet::report {
namespace {

/// From this ratio of the largest to the smallest value on, an axis is logarithmic.
constexpr double many = 30.0;

/// A column of results.csv to be drawn.
struct Drawn {
  std::string column, heading, note, title, quantity;
  /// Points, each with "at", "value", "sign" and "source", one with an error with "low" and "high".
  Json measured = Json::array();
};

/// Signs of measured points, in the order of their sources.
constexpr std::array<const char*, 4> signs{"\u25c7", "\u25b3", "\u25a1", "\u2715"};

/// Draws and tells beside a value what was measured of it.
void add_measured(const Json& study, const std::string& value, Drawn& drawn_column) {
  std::size_t sources = 0;
  for (const auto& one : study.value("measured", Json::array())) {
    if (one.at("value") != value) continue;
    const auto* sign = signs.at(sources++ % signs.size());
    const auto source = one.at("source").get<std::string>();
    drawn_column.note += fmt::format(" {} measured: {}.", sign, source);
    for (std::size_t i = 0; i < one.at("at").size(); ++i) {
      const double is = std::abs(one.at("measured")[i].get<double>());  // like the runs' values
      Json point{{"at", one.at("at")[i]}, {"value", is}, {"sign", sign}, {"source", source}};
      if (one.at("error").is_number()) {
        point["low"] = is - one.at("error").get<double>();
        point["high"] = is + one.at("error").get<double>();
      }
      drawn_column.measured.push_back(point);
    }
  }
}

std::vector<Drawn> columns_of(const Json& study) {
  std::vector<Drawn> all;
  const auto& histories = study.at("histories");
  if (!histories.is_null()) {
    const auto title = "RMS / " + histories.at("over_name").get<std::string>();
    const auto compared = histories.at("compare_to").get<std::string>(), history = history_title(study);
    all.push_back({"rms_compared", "Difference from " + compared,
                   fmt::format("RMS of the difference of the {} from {} at the same settings, over its contact period.",
                               history, compared),
                   title, ""});
    all.push_back({"rms_reference", "Difference from the reference",
                   fmt::format("RMS of the difference of the {} from the reference, over its contact period.", history),
                   title, ""});
  }
  for (const auto& value : told_values(study)) {
    all.push_back({"value_" + value, "Magnitude of " + value, "As the runs have it.", value, ""});
    add_measured(study, value, all.back());
  }
  for (const auto& quantity : texts(study, "quantities")) {
    const bool drift = quantity == "energy_drift";
    all.push_back({"error_" + quantity, drift ? "Energy drift" : "Error of the " + words(quantity),
                   drift ? "The run's own, over the initial energy." : "Against the reference.",
                   drift ? "energy drift" : "relative error", quantity});
  }
  all.push_back({"stepping_s", "Time of stepping", "Median of the repeats.", "stepping [s]", ""});
  all.push_back({"wall_s", "Wall time", "The whole run, median of the repeats.", "wall time [s]", ""});
  return all;
}

bool logarithmic(const std::vector<double>& values) {
  if (values.empty()) return false;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return *least > 0.0 && *most > many * *least;
}

Json points_with(const Json& points, const char* key) {
  Json found = Json::array();
  for (const auto& point : points)
    if (point.contains(key)) found.push_back(point);
  return found;
}

/// The horizontal encoding: numbers of the study's own axis, or the values of its key one beside the other.
Json across(const Json& axis, const std::string& along) {
  if (!axis.is_null()) {
    std::vector<double> numbers;
    for (const auto& [text, number] : axis.at("at").items()) numbers.push_back(number);
    const bool log = logarithmic(numbers);
    return {{"field", "at"},
            {"type", "quantitative"},
            {"title", axis.at("title")},
            {"scale", {{"type", log ? "log" : "linear"}, {"nice", !log}, {"padding", 12}}}};
  }
  return {{"field", "at"},
          {"type", "ordinal"},
          {"sort", nullptr},
          {"title", along},
          {"axis", {{"labelAngle", 0}, {"labelOverlap", true}}}};
}

Chart chart_of(const Json& study, const Panel& panel, const Drawn& drawn_column, std::size_t number_of_panel) {
  const auto along = study.at("along").get<std::string>();
  const auto axis = study.value("axis", Json());
  const auto methods = texts(study, "methods");
  const auto looks = looks_of(methods);
  Chart chart;
  chart.id = identifier(fmt::format("along_{}_{}", drawn_column.column, number_of_panel));
  chart.title = panel.title;
  chart.columns = {"at", "value", "method"};
  std::vector<double> values;
  for (const auto* row : panel.rows) {
    const auto value = number(*row, drawn_column.column);
    if (!value || *value == 0.0) continue;
    const auto& at = row->at(along);
    // A method that does not vary the key has no place on an axis of numbers.
    if (!axis.is_null() && !axis.at("at").contains(at)) continue;
    values.push_back(std::abs(*value));
    chart.rows.push_back({axis.is_null() ? Json(at) : axis.at("at").at(at), drawn(values.back()), row->at("method")});
  }
  const bool log = logarithmic(values);
  const Json scale = log ? Json({{"type", "log"}, {"nice", false}, {"padding", 12}}) : Json({{"zero", true}});
  const auto rule = drawn_column.quantity.empty() ? Json::array() : reference_rule(study, drawn_column.quantity);
  chart.spec = without_empty_layers(fill_json(
      asset("along.json"), {{"description", Json(drawn_column.heading + " along " + along + ": " + panel.title).dump()},
                            {"width", Json(panel_width).dump()},
                            {"at", across(axis, along).dump()},
                            {"at_title", (axis.is_null() ? Json(along) : axis.at("title")).dump()},
                            {"error_bars", points_with(drawn_column.measured, "low").dump()},
                            {"measured", drawn_column.measured.dump()},
                            {"value_title", Json(drawn_column.title).dump()},
                            {"scale", scale.dump()},
                            {"format", log ? "\".1~e\"" : "\".6~g\""},
                            {"reference", rule.dump()},
                            {"methods", Json(methods).dump()},
                            {"colors", looks.colors.dump()},
                            {"shapes", looks.shapes.dump()},
                            {"dashes", looks.dashes.dump()}}));
  return chart;
}

}  // namespace

std::string along_html(const Json& study, const std::vector<CsvRow>& rows, std::vector<std::string>& json) {
  const auto along = study.at("along").get<std::string>();
  if (along.empty()) return "";
  const auto together = texts(study, "along_together");  // keys that take their values with it
  std::vector<std::string> others;
  for (const auto& axis : texts(study, "axes")) {
    if (std::find(together.begin(), together.end(), axis) == together.end()) others.push_back(axis);
  }
  const auto panels = panels_of(rows, others);
  std::string text;
  std::vector<Chart> alone;  // the only chart of its column
  for (const auto& column : columns_of(study)) {
    std::vector<Chart> charts;
    for (const auto& panel : panels) {
      auto chart = chart_of(study, panel, column, charts.size() + 1);
      if (!chart.rows.empty()) charts.push_back(std::move(chart));
    }
    if (panels.size() > 1) {
      text += panels_html(fmt::format("{} along {}", column.heading, along), column.note, charts, json);
    } else if (!charts.empty()) {
      charts.front().title = column.heading;
      charts.front().note = column.note;
      alone.push_back(std::move(charts.front()));
    }
  }
  return text + panels_html("Along " + along, "", alone, json);
}

}  // namespace ricochet::report
