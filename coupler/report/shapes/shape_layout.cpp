#include "coupler/report/shapes/shape_layout.hpp"

#include <algorithm>
#include <limits>

namespace ricochet::report {

Extent Extent::empty() {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  return {{infinite, infinite}, {-infinite, -infinite}};
}

void Extent::include(const Pixel& x) {
  for (std::size_t c = 0; c < 2; ++c) {
    low[c] = std::min(low[c], x[c]);
    high[c] = std::max(high[c], x[c]);
  }
}

Pixel PanelLayout::corner(std::size_t panel) const {
  const std::size_t row = panel / columns;
  const double names = row > 0 ? line_px : 0.0;
  return {static_cast<double>(panel % columns) * (panel_width_px + gap_px),
          names + line_px + static_cast<double>(row) * (panel_height_px + line_px)};
}

Pixel PanelLayout::at(std::size_t panel, const Pixel& x) const {
  const auto left_upper = corner(panel);
  const double middle = 0.5 * (extent.low[1] + extent.high[1]);
  return {left_upper[0] + 0.5 * (panel_width_px - scale_px_m * extent.width()) + scale_px_m * (x[0] - extent.low[0]),
          left_upper[1] + 0.5 * panel_height_px - scale_px_m * (x[1] - middle)};
}

double PanelLayout::height_px() const { return line_px + static_cast<double>(rows) * (panel_height_px + line_px); }

PanelLayout layout_of(std::size_t panels, const Extent& extent, double width_px, double most_height_px,
                      double thickness_px) {
  constexpr double gap_px = 16, margin_px = 4;
  PanelLayout best;
  best.scale_px_m = 0.0;
  const double wide = std::max(extent.width(), 1e-9 * extent.height()), high = std::max(extent.height(), 1e-9 * wide);
  for (std::size_t columns = 1; columns <= panels; ++columns) {
    PanelLayout layout;
    layout.columns = columns;
    layout.rows = (panels + columns - 1) / columns;
    layout.gap_px = gap_px;
    layout.extent = extent;
    const auto of = [](double all, std::size_t count) { return all / static_cast<double>(count); };
    layout.panel_width_px = of(width_px - static_cast<double>(columns - 1) * gap_px, columns);
    const double room_px = of(most_height_px - PanelLayout::line_px, layout.rows) - PanelLayout::line_px;
    layout.scale_px_m = std::min((layout.panel_width_px - 2 * margin_px) / wide, (room_px - 2 * margin_px) / high);
    layout.panel_height_px = std::max(thickness_px, layout.scale_px_m * extent.height()) + 2 * margin_px;
    if (layout.scale_px_m > best.scale_px_m) best = layout;
  }
  return best;
}

}  // namespace ricochet::report
