#pragma once

#include <cstddef>
#include <vector>

#include "coupler/report/shapes/canvas.hpp"

namespace ricochet::report {

/// A rectangle to the right and up [m].
struct Extent {
  Pixel low{}, high{};

  [[nodiscard]] static Extent empty();
  void include(const Pixel& x);
  [[nodiscard]] double width() const { return high[0] - low[0]; }
  [[nodiscard]] double height() const { return high[1] - low[1]; }
};

/// Equal panels in rows, one for each time, all with the same piece of the plane in them.
struct PanelLayout {
  static constexpr double line_px = 18;  ///< above each panel, for its time; below the first row, for names

  std::size_t columns = 1, rows = 1;
  double scale_px_m = 1.0;
  double panel_width_px = 0, panel_height_px = 0, gap_px = 0;
  Extent extent;

  /// Left upper corner of a panel's picture.
  [[nodiscard]] Pixel corner(std::size_t panel) const;
  /// Where something is seen in a panel.
  [[nodiscard]] Pixel at(std::size_t panel, const Pixel& x) const;
  [[nodiscard]] double height_px() const;
};

/// As many columns as show `panels` panels of this extent the largest within `width_px` and, unless a panel alone is
/// higher, `most_height_px`. `thickness_px`: the least height of a panel.
[[nodiscard]] PanelLayout layout_of(std::size_t panels, const Extent& extent, double width_px, double most_height_px,
                                    double thickness_px);

}  // namespace ricochet::report
