#include "coupler/report/shapes/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace ricochet::report {
namespace {

constexpr std::array<double, ShadedPalette::shades> brightness = {1.0, 0.95, 0.87, 0.55};
constexpr int first_level = 2;  // after background and line

}  // namespace

ShadedPalette::ShadedPalette(const std::vector<Rgb>& colours) : colours_{{255, 255, 255}, {25, 25, 25}} {
  for (int level = 0; level < levels; ++level) {
    const double at = static_cast<double>(level) / (levels - 1) * static_cast<double>(colours.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), colours.size() - 2);
    const double share = at - static_cast<double>(below);
    for (const double bright : brightness) {
      Rgb mixed{};
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = (1 - share) * colours[below][c] + share * colours[below + 1][c];
        mixed[c] = static_cast<std::uint8_t>(std::lround(bright * value));
      }
      colours_.push_back(mixed);
    }
  }
}

std::uint8_t ShadedPalette::index(double share, int shade) {
  const auto level = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * (levels - 1)));
  return static_cast<std::uint8_t>(first_level + level * shades + shade);
}

std::uint8_t ShadedPalette::darkest(std::uint8_t index) {
  if (index < first_level) return index;
  return static_cast<std::uint8_t>(index + (shades - 1) - (index - first_level) % shades);
}

Canvas::Canvas(int width, int height) : width_(width), height_(height) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  colour_.assign(pixels, ShadedPalette::background);
  cell_.assign(pixels, -1);
}

/// Stretches of pixels [begin, end) between the first and the last crossing of each row's middle, which of a convex
/// polygon are all there are.
template <class Each>
void Canvas::inside(std::span<const Pixel> corners, Each each) const {
  double top = height_, bottom = 0;
  for (const auto& corner : corners) {
    top = std::min(top, corner[1]);
    bottom = std::max(bottom, corner[1]);
  }
  const int first = static_cast<int>(std::max(0.0, std::ceil(top - 0.5)));
  const int last = static_cast<int>(std::min(height_ - 1.0, std::floor(bottom - 0.5)));
  for (int y = first; y <= last; ++y) {
    const double middle = y + 0.5;
    double left = width_, right = -1;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
      if ((a[1] <= middle) == (b[1] <= middle)) continue;
      // From the upper end whichever way round, so that polygons which share an edge agree to the last bit.
      const auto &high = a[1] < b[1] ? a : b, &low = a[1] < b[1] ? b : a;
      const double x = high[0] + (middle - high[1]) / (low[1] - high[1]) * (low[0] - high[0]);
      left = std::min(left, x);
      right = std::max(right, x);
    }
    const int begin = static_cast<int>(std::max(0.0, std::ceil(left - 0.5)));
    const int end = static_cast<int>(std::min(width_ - 1.0, std::ceil(right - 0.5) - 1.0));
    if (begin <= end) each(begin, end + 1, y);
  }
}

template <class Each>
void Canvas::along(const Pixel& from, const Pixel& to, int thickness, Each each) const {
  const double longest = std::max(std::abs(to[0] - from[0]), std::abs(to[1] - from[1]));
  if (!(longest < 4.0 * (width_ + height_))) return;                          // far out of the picture
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * longest)));  // rounding skips no pixel
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps, half = 0.5 * (thickness - 1);
    const int x0 = static_cast<int>(std::floor(from[0] + share * (to[0] - from[0]) - half));
    const int y0 = static_cast<int>(std::floor(from[1] + share * (to[1] - from[1]) - half));
    for (int y = std::max(0, y0); y < std::min(height_, y0 + thickness); ++y) {
      for (int x = std::max(0, x0); x < std::min(width_, x0 + thickness); ++x) each(x, y);
    }
  }
}

void Canvas::fill(std::span<const Pixel> corners, std::uint8_t colour, int cell) {
  inside(corners, [&](int begin, int end, int y) {
    std::fill_n(&colour_[at(begin, y)], end - begin, colour);
    std::fill_n(&cell_[at(begin, y)], end - begin, cell);
  });
}

void Canvas::dot(std::span<const Pixel> corners, int spacing, int size) {
  inside(corners, [&](int begin, int end, int y) {
    for (int x = begin; x < end; ++x) {
      if (x % spacing < size && y % spacing < size) colour_[at(x, y)] = ShadedPalette::line;
    }
  });
}

void Canvas::darken(const Pixel& from, const Pixel& to, int thickness) {
  along(from, to, thickness, [&](int x, int y) { colour_[at(x, y)] = ShadedPalette::darkest(colour_[at(x, y)]); });
}

void Canvas::draw(const Pixel& from, const Pixel& to, int thickness) {
  along(from, to, thickness, [&](int x, int y) { colour_[at(x, y)] = ShadedPalette::line; });
}

std::string Canvas::png_of(const ShadedPalette& palette) const {
  return png(static_cast<std::size_t>(width_), static_cast<std::size_t>(height_), colour_, palette.colours());
}

}  // namespace ricochet::report
