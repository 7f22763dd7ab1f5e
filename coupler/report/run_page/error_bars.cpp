#include "coupler/report/run_page/error_bars.hpp"

#include <fmt/format.h>

#include "coupler/report/parts/text.hpp"
#include "coupler/report/run_page/summary_page.hpp"

namespace ricochet::report {
namespace {

std::string error_cell(const Json& quantity, const char* key, int digits = 2) {
  const auto found = quantity.find(key);
  const bool known = found != quantity.end() && found->is_number();
  return "<td>" + (known ? fmt::format("{:.{}g}", found->get<double>(), digits) : std::string("unknown")) + "</td>";
}

/// The text on what the scene asks for.
std::string asked_text(const Json& quantity) {
  const auto asked = number(quantity, "asked");
  if (!asked) return "";
  return fmt::format("; asked {:g} %: {}", 100.0 * *asked,
                     quantity.value("reached", false) ? "reached" : "not reached");
}

}  // namespace

std::string error_bars_html(const Json& summary) {
  const Json block = summary.value("error_bar", Json::object());
  const Json quantities = block.value("quantities", Json::object());
  if (quantities.empty()) return "";
  std::string text =
      "<table>\n<thead><tr><th>error bars, each in the unit of its name</th><th>value</th><th>error</th><th>time</th>"
      "<th>space</th><th>coupling</th><th>contact law</th><th>levels</th></tr></thead>\n<tbody>\n";
  for (const auto& [name, quantity] : quantities.items()) {
    text += "<tr><th scope=\"row\">" + escape_html(name) + "</th>" + error_cell(quantity, "value", 5);
    for (const char* part : {"total", "time", "space", "coupling", "contact_law"}) text += error_cell(quantity, part);
    text += "<td>" + escape_html(quantity.value("found", "")) + asked_text(quantity) + "</td></tr>\n";
  }
  return text + "</tbody>\n</table>\n";
}

}  // namespace ricochet::report
