#pragma once

#include <string>
#include <vector>

#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/csv_table.hpp"

/// The parts that the charts and tables of a study's page share. `study` is its study.json.
namespace ricochet::report {

/// Width of the plotting area of a chart that shares its line with another one [px].
inline constexpr int panel_width = 415;

/// A list of texts; throws Json::exception if there is none of that name.
[[nodiscard]] std::vector<std::string> texts(const Json& study, const char* key);

/// The values that a study tells of its runs; none in one from before there were any.
[[nodiscard]] std::vector<std::string> told_values(const Json& study);

/// "peak_force" as "peak force".
[[nodiscard]] std::string words(const std::string& name);
/// Letters, digits and underscores alone, another one for every name: what a chart goes by in the page and as a file.
[[nodiscard]] std::string identifier(const std::string& name);

/// How methods are told apart, one entry a method: by shape and dash as much as by colour.
struct MethodLooks {
  Json colors = Json::array(), shapes = Json::array(), dashes = Json::array();
};
[[nodiscard]] MethodLooks looks_of(const std::vector<std::string>& methods);

/// Rule for the reference's own error of a quantity, the largest one of several references; empty where it is exact
/// or has no such error.
[[nodiscard]] Json reference_rule(const Json& study, const std::string& quantity);

/// Vega complains of layers without data.
[[nodiscard]] std::string without_empty_layers(const std::string& spec);

/// Whether a run has these settings, a table of texts as they stand in results.csv.
[[nodiscard]] bool has_settings(const CsvRow& row, const Json& settings);

/// The runs with the same settings of `axes`.
struct Panel {
  std::string title;  ///< these settings; empty without axes
  std::vector<const CsvRow*> rows;
};

/// All runs by their settings of `axes`, in the order of the runs.
[[nodiscard]] std::vector<Panel> panels_of(const std::vector<CsvRow>& rows, const std::vector<std::string>& axes);

/// Two charts a line below a heading, and their JSON into `json`.
[[nodiscard]] std::string panels_html(const std::string& heading, const std::string& note,
                                      const std::vector<Chart>& charts, std::vector<std::string>& json);

/// <tag>text</tag>, the text escaped.
[[nodiscard]] std::string cell(const std::string& tag, const std::string& text);

}  // namespace ricochet::report
