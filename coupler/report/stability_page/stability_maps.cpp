#include "coupler/report/stability_page/stability_maps.hpp"

#include <fmt/format.h>

#include <string>

#include "coupler/report/stability_page/stability_page.hpp"

namespace ricochet::report {

std::vector<Chart> stability_maps(const std::filesystem::path& folder) {
  const auto own =
      std::filesystem::absolute(folder / "x").lexically_normal().parent_path();  // without a slash at its end
  const auto beside = own.parent_path() / (own.filename().string() + "_stability");
  for (const auto& place : {own, beside}) {
    const auto path = (place / "stability.json").string();
    if (!std::filesystem::exists(path)) continue;
    auto charts = stability_charts(read_stability_map(path));
    for (auto& chart : charts) chart.title = "Stability of the coupled scheme: " + chart.title;
    const auto from = std::filesystem::relative(path, own).string();
    if (!charts.empty()) charts.front().note = fmt::format("From {}, for the scene file as it was then.", from);
    return charts;
  }
  return {};
}

}  // namespace ricochet::report
