#include "coupler/report/parts/libraries.hpp"

#include <fmt/format.h>

#include "coupler/report/assets/assets.hpp"
#include "coupler/report/parts/text.hpp"

namespace ricochet::report {

std::string libraries_html() {
  std::string text;
  for (const std::string library : {"vega", "vega-lite", "vega-embed"}) {
    text += fmt::format("<script>/*! {}\n{}*/\n{}</script>\n", library, asset(library + ".license"),
                        inside_script(asset(library + ".js")));
  }
  return text + fmt::format("<script>/*! chart_spec\n*/\n{}</script>\n", inside_script(asset("chart_spec.js")));
}

}  // namespace ricochet::report
