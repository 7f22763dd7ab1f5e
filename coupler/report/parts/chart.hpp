#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ricochet::report {

using Json = nlohmann::ordered_json;

/// Width of every chart's plotting area [px]; histories are thinned to it.
inline constexpr int chart_width = 880;

/// One chart of the page: a Vega-Lite specification whose placeholders are filled, and the table that it draws. page.js
/// makes the table its data; specifications hold none of their own, because arrays without names are much smaller.
struct Chart {
  std::string id;  ///< of the HTML element, and name of a saved picture
  std::string title;
  std::string note;     ///< below the title; may be empty
  std::string caption;  ///< follows the note where the chart stands alone, as a picture file; may be empty
  std::string link;     ///< charts with the same word zoom together; empty: it does not zoom
  std::string spec;     ///< Vega-Lite JSON
  std::vector<std::string> columns;
  Json rows = Json::array();
};

/// Input of page.js and draw_pictures.js: {"id", "title", "note", "link", "columns", "rows", "spec"}.
[[nodiscard]] std::string to_json(const Chart& chart);

/// The HTML frame that page.js draws it into.
[[nodiscard]] std::string to_html(const Chart& chart);

/// A finite number with 6 significant digits, else null: what a chart can show, in few bytes.
[[nodiscard]] Json drawn(double value);

}  // namespace ricochet::report
