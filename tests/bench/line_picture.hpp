#pragma once

#include <string>
#include <vector>

namespace ricochet::bench {

/// One line of a picture; `dash` as in SVG's stroke-dasharray, "" for a full line.
struct PictureLine {
  std::string label, colour, dash;
  std::vector<double> x, y;  ///< of equal length
};

/// Lines over common axes as SVG text: ticks, axis labels, legend. x reaches to its largest value, y from 0 to `y_end`;
/// what lies above is cut off, and said under the title with its value. Labels hold no characters that XML reserves.
[[nodiscard]] std::string line_picture(const std::string& title, const std::string& x_label, const std::string& y_label,
                                       const std::vector<PictureLine>& lines, double y_end);

}  // namespace ricochet::bench
