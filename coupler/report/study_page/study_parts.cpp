#include "coupler/report/study_page/study_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "coupler/report/parts/text.hpp"

namespace ricochet::report {
namespace {

/// Okabe and Ito's colours, told apart by colour-blind readers.
struct Look {
  const char *color, *shape;
  std::vector<int> dash;
};
const std::vector<Look>& looks() {
  static const std::vector<Look> all{{"#0072b2", "circle", {1, 0}},         {"#d55e00", "square", {7, 3}},
                                     {"#009e73", "triangle-up", {2, 2}},    {"#cc79a7", "diamond", {9, 3, 2, 3}},
                                     {"#000000", "cross", {4, 2}},          {"#e69f00", "triangle-down", {12, 3}},
                                     {"#56b4e9", "triangle-right", {3, 5}}, {"#8a6d00", "triangle-left", {1, 3}},
                                     {"#666666", "stroke", {6, 6}}};
  return all;
}

std::string title_of(const CsvRow& row, const std::vector<std::string>& axes) {
  std::vector<std::string> settings;
  for (const auto& axis : axes) {
    const auto& value = row.at(axis);
    settings.push_back(fmt::format("{} = {}", axis, value.empty() ? "the scene's" : value));
  }
  return fmt::format("{}", fmt::join(settings, ", "));
}

}  // namespace

std::vector<std::string> texts(const Json& study, const char* key) {
  return study.at(key).get<std::vector<std::string>>();
}

std::vector<std::string> told_values(const Json& study) {
  return study.contains("values") ? texts(study, "values") : std::vector<std::string>();
}

std::string words(const std::string& name) {
  const auto slash = name.find('/');
  std::string quantity = name.substr(0, slash);
  std::replace(quantity.begin(), quantity.end(), '_', ' ');
  return slash == std::string::npos ? quantity : quantity + " at " + name.substr(slash + 1);
}

std::string identifier(const std::string& name) {
  std::string text;
  for (const char c : name) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
    text += plain ? std::string(1, c) : fmt::format("_{:02x}", static_cast<unsigned char>(c));
  }
  return text;
}

MethodLooks looks_of(const std::vector<std::string>& methods) {
  MethodLooks result;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const auto& look = looks()[m % looks().size()];
    result.colors.push_back(look.color);
    result.shapes.push_back(look.shape);
    result.dashes.push_back(look.dash);
  }
  return result;
}

Json reference_rule(const Json& study, const std::string& quantity) {
  double largest = 0.0;
  for (const auto& reference : study.at("references")) {
    const auto& errors = reference.at("errors");
    if (errors.contains(quantity) && errors.at(quantity).is_number())
      largest = std::max(largest, errors.at(quantity).get<double>());
  }
  if (largest == 0.0 || quantity == "energy_drift") return Json::array();
  return Json::array({{{"error", drawn(largest)}, {"label", "error of the reference itself"}}});
}

std::string without_empty_layers(const std::string& spec_text) {
  Json spec = Json::parse(spec_text), layers = Json::array();
  for (const auto& layer : spec.at("layer")) {
    if (!layer.contains("data") || !layer.at("data").at("values").empty()) layers.push_back(layer);
  }
  spec["layer"] = layers;
  return spec.dump();
}

bool has_settings(const CsvRow& row, const Json& settings) {
  for (const auto& [key, value] : settings.items()) {
    if (row.at(key) != value.get<std::string>()) return false;
  }
  return true;
}

std::vector<Panel> panels_of(const std::vector<CsvRow>& rows, const std::vector<std::string>& axes) {
  std::vector<Panel> panels;
  for (const auto& row : rows) {
    const auto title = title_of(row, axes);
    auto panel = std::find_if(panels.begin(), panels.end(), [&](const Panel& p) { return p.title == title; });
    if (panel == panels.end()) panel = panels.insert(panels.end(), {title, {}});
    panel->rows.push_back(&row);
  }
  return panels;
}

std::string panels_html(const std::string& heading, const std::string& note, const std::vector<Chart>& charts,
                        std::vector<std::string>& json) {
  if (charts.empty()) return "";
  std::string text =
      fmt::format("<h2>{}</h2>\n<p>{}</p>\n<div class=\"panels\">\n", escape_html(heading), escape_html(note));
  for (const auto& chart : charts) {
    text += to_html(chart);
    json.push_back(to_json(chart));
  }
  return text + "</div>\n";
}

std::string cell(const std::string& tag, const std::string& text) {
  return fmt::format("<{0}>{1}</{0}>", tag, escape_html(text));
}

}  // namespace ricochet::report
