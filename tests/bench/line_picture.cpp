#include "tests/bench/line_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ricochet::bench {
namespace {

constexpr double width = 760, height = 440, left = 70, right = 20, top = 60, bottom = 55, legend_row = 18;

/// From 0 to `end`, in pixels.
struct Axis {
  double end, first_px, last_px;
  [[nodiscard]] double px(double value) const { return first_px + (last_px - first_px) * value / end; }
  /// Three to eight steps of 1, 2 or 5 times a power of ten.
  [[nodiscard]] double tick() const {
    const double rough = end / 8.0, power = std::pow(10.0, std::floor(std::log10(rough)));
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (factor * power >= rough) return factor * power;
    }
    return 10.0 * power;
  }
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> values;
    for (int i = 0; i * tick() <= end * (1.0 + 1e-9); ++i) values.push_back(i * tick());
    return values;
  }
};

std::string text(double x, double y, const char* anchor, const std::string& words, const char* more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more, words);
}

std::string segment(double x0, double y0, double x1, double y1, const std::string& stroke) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x0, y0, x1, y1, stroke);
}

std::string stroke_of(const PictureLine& line) {
  return fmt::format("stroke=\"{}\" stroke-width=\"1.8\" stroke-dasharray=\"{}\" fill=\"none\"", line.colour,
                     line.dash.empty() ? "none" : line.dash);
}

std::string drawn_axes(const Axis& x, const Axis& y, const std::string& x_label, const std::string& y_label) {
  std::string svg;
  const std::string grid = "stroke=\"#dddddd\"", black = "stroke=\"#000000\"";
  for (const double value : x.ticks()) {
    svg += segment(x.px(value), y.first_px, x.px(value), y.last_px, grid);
    svg += text(x.px(value), y.first_px + 18, "middle", fmt::format("{:g}", value));
  }
  for (const double value : y.ticks()) {
    svg += segment(x.first_px, y.px(value), x.last_px, y.px(value), grid);
    svg += text(x.first_px - 8, y.px(value) + 4, "end", fmt::format("{:g}", value));
  }
  svg += segment(x.first_px, y.first_px, x.last_px, y.first_px, black);
  svg += segment(x.first_px, y.first_px, x.first_px, y.last_px, black);
  svg += text(0.5 * (x.first_px + x.last_px), height - 12, "middle", x_label);
  const double middle = 0.5 * (y.first_px + y.last_px);
  return svg + text(18, middle, "middle", y_label, fmt::format(" transform=\"rotate(-90 18 {:.1f})\"", middle).c_str());
}

/// Cut at the top edge of the picture, between points as well as at them.
std::string drawn_line(const PictureLine& line, const Axis& x, const Axis& y) {
  std::string points;
  for (std::size_t i = 0; i < line.x.size(); ++i)
    points += fmt::format("{:.2f},{:.2f} ", x.px(line.x[i]), y.px(line.y[i]));
  return fmt::format("<polyline points=\"{}\" {} clip-path=\"url(#plot)\"/>\n", points, stroke_of(line));
}

std::string cut_off(const std::vector<PictureLine>& lines, double y_end) {
  std::string words;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.y.size(); ++i) {
      if (line.y[i] <= y_end) continue;
      words += fmt::format("{}{}: {:.4g} at {:.3g}", words.empty() ? "above the picture: " : "; ", line.label,
                           line.y[i], line.x[i]);
    }
  }
  return words;
}

std::string legend(const std::vector<PictureLine>& lines, double y_px) {
  std::string svg;
  y_px -= legend_row * static_cast<double>(lines.size() + 1);
  for (const auto& line : lines) {
    y_px += legend_row;
    svg += segment(width - right - 190, y_px, width - right - 150, y_px, stroke_of(line));
    svg += text(width - right - 142, y_px + 4, "start", line.label);
  }
  return svg;
}

}  // namespace

std::string line_picture(const std::string& title, const std::string& x_label, const std::string& y_label,
                         const std::vector<PictureLine>& lines, double y_end) {
  double x_end = 0.0;
  for (const auto& line : lines) {
    if (!line.x.empty()) x_end = std::max(x_end, line.x.back());
  }
  const Axis x{x_end, left, width - right}, y{y_end, height - bottom, top};
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" width=\"{0:g}\" height=\"{1:g}\" "
      "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"#ffffff\"/>\n"
      "<clipPath id=\"plot\"><rect x=\"{2:g}\" y=\"{3:g}\" width=\"{4:g}\" height=\"{5:g}\"/></clipPath>\n",
      width, height, left, top, width - left - right, height - top - bottom);
  svg += text(left, 24, "start", title, " font-size=\"15\"") + text(left, 46, "start", cut_off(lines, y_end));
  svg += drawn_axes(x, y, x_label, y_label);
  for (const auto& line : lines) svg += drawn_line(line, x, y);
  return svg + legend(lines, y.first_px) + "</svg>\n";
}

}  // namespace ricochet::bench
