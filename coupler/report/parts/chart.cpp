#include "coupler/report/parts/chart.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "coupler/report/parts/text.hpp"

namespace ricochet::report {

std::string to_json(const Chart& chart) {
  const std::string note = chart.note + (chart.note.empty() || chart.caption.empty() ? "" : " ") + chart.caption;
  return fmt::format(R"({{"id": {}, "title": {}, "note": {}, "link": {}, "columns": {}, "rows": {}, "spec": {}}})",
                     Json(chart.id).dump(), Json(chart.title).dump(), Json(note).dump(), Json(chart.link).dump(),
                     Json(chart.columns).dump(), chart.rows.dump(), chart.spec);
}

std::string to_html(const Chart& chart) {
  const std::string note = chart.note.empty() ? "" : fmt::format("<p>{}</p>", escape_html(chart.note));
  return fmt::format(
      "<figure>\n<figcaption><h2>{}</h2>{}</figcaption>\n<div class=\"chart\" id=\"{}\"></div>\n</figure>\n",
      escape_html(chart.title), note, escape_html(chart.id));
}

Json drawn(double value) {
  // Rounded by way of text: the nearest double of 6 digits is also written with 6 digits.
  return std::isfinite(value) ? Json(std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr)) : Json(nullptr);
}

}  // namespace ricochet::report
