#include "coupler/report/stability_maps.hpp"

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "coupler/report/history_table.hpp"

namespace ricochet::report {
namespace {

Chart chart_of(const Json& stored) {
  Chart chart;
  chart.id = stored.at("id");
  chart.title = "Stability of the coupled scheme: " + stored.value("title", chart.id);
  chart.note = stored.value("note", "");
  chart.link = stored.at("link");
  chart.columns = stored.at("columns").get<std::vector<std::string>>();
  chart.rows = stored.at("rows");
  chart.spec = stored.at("spec").dump();
  return chart;
}

/// The text between the tags of <script id="charts">; empty if there is none.
std::string_view charts_of(std::string_view page) {
  constexpr std::string_view open = R"(<script type="application/json" id="charts">)";
  const auto begin = page.find(open);
  if (begin == std::string_view::npos) return {};
  page.remove_prefix(begin + open.size());
  return page.substr(0, page.find("</script>"));
}

}  // namespace

std::vector<Chart> stability_maps(const std::filesystem::path& folder) {
  const auto own =
      std::filesystem::absolute(folder / "x").lexically_normal().parent_path();  // without a slash at its end
  const auto beside = own.parent_path() / (own.filename().string() + "_stability");
  std::vector<Chart> charts;
  for (const auto& place : {own, beside}) {
    const auto path = (place / "stability.html").string();
    if (!charts.empty() || !std::filesystem::exists(path)) continue;
    const std::string page = read_text(path);
    try {
      for (const auto& stored : Json::parse(charts_of(page))) charts.push_back(chart_of(stored));
    } catch (const Json::exception& error) {
      throw ConfigError(
          fmt::format("{} is not a page of ricochet stability: {}; run that again or remove it", path, error.what()));
    }
    const auto from = std::filesystem::relative(path, own).string();
    if (!charts.empty()) charts.front().note = fmt::format("From {}, for the scene file as it was then.", from);
  }
  return charts;
}

}  // namespace ricochet::report
