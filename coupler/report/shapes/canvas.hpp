#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "coupler/report/parts/png.hpp"

namespace ricochet::report {

using Pixel = std::array<double, 2>;  ///< from the left, from the top

/// Colours along a scale, each in a few shades, and what has no value: at most 256 in all.
class ShadedPalette {
 public:
  static constexpr int levels = 63, shades = 4;
  static constexpr std::uint8_t background = 0, line = 1;

  /// `colours`: equally spaced along the scale.
  explicit ShadedPalette(const std::vector<Rgb>& colours);
  /// `share` of the scale, from 0 to 1 (beyond: the end); shade 0 is the colour itself, the last one the darkest.
  [[nodiscard]] static std::uint8_t index(double share, int shade);
  /// The darkest shade of a colour of the scale; any other index as it is.
  [[nodiscard]] static std::uint8_t darkest(std::uint8_t index);
  [[nodiscard]] const std::vector<Rgb>& colours() const { return colours_; }

 private:
  std::vector<Rgb> colours_;
};

/// Pixels, each with a colour of the palette and the number of the cell that is seen there.
class Canvas {
 public:
  Canvas(int width, int height);

  /// A polygon that is convex or nearly so: pixels whose centre lies inside. Polygons that share an edge leave no pixel
  /// between them.
  void fill(std::span<const Pixel> corners, std::uint8_t colour, int cell);
  /// Black dots on what is seen of a polygon, in a grid over the whole canvas.
  void dot(std::span<const Pixel> corners, int spacing, int size);
  /// Of `thickness` pixels, in the darkest shade of what is there.
  void darken(const Pixel& from, const Pixel& to, int thickness);
  /// In the colour of lines.
  void draw(const Pixel& from, const Pixel& to, int thickness);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::uint8_t colour(int x, int y) const { return colour_[at(x, y)]; }
  [[nodiscard]] int cell(int x, int y) const { return cell_[at(x, y)]; }  ///< -1: none
  [[nodiscard]] std::string png_of(const ShadedPalette& palette) const;

 private:
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  template <class Each>
  void inside(std::span<const Pixel> corners, Each each) const;
  template <class Each>
  void along(const Pixel& from, const Pixel& to, int thickness, Each each) const;

  int width_, height_;
  std::vector<std::uint8_t> colour_;
  std::vector<int> cell_;
};

}  // namespace ricochet::report
