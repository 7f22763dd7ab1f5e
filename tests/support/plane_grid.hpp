#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace ricochet::test {

/// across x up quadrilaterals over places in the plane, counter-clockwise, and MSH 4.1 text of them.
struct PlaneGrid {
  using Place = std::pair<double, double>;
  using Edges = std::vector<std::pair<int, int>>;

  int across, up;
  std::vector<Place> places;

  /// `place`(a, b) of 0 <= a, b <= 1
  template <class F>
  PlaneGrid(int cells_across, int cells_up, const F& place) : across(cells_across), up(cells_up) {
    for (int j = 0; j <= up; ++j)
      for (int i = 0; i <= across; ++i)
        places.push_back(place(static_cast<double>(i) / across, static_cast<double>(j) / up));
  }

  [[nodiscard]] int node(int i, int j) const { return j * (across + 1) + i + 1; }
  [[nodiscard]] Edges low() const { return along_first(0); }
  [[nodiscard]] Edges high() const { return along_first(up); }
  [[nodiscard]] Edges left() const { return along_second(0); }
  [[nodiscard]] Edges right() const { return along_second(across); }

  [[nodiscard]] std::string msh(const std::string& body,
                                const std::vector<std::pair<std::string, Edges>>& surfaces) const {
    const auto count = surfaces.size(), nodes = places.size();
    std::string text = fmt::format("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n", count + 1);
    for (std::size_t s = 0; s < count; ++s) text += fmt::format("1 {} \"{}\"\n", s + 1, surfaces[s].first);
    text += fmt::format("2 {} \"{}\"\n$EndPhysicalNames\n$Entities\n0 {} 1 0\n", count + 1, body, count);
    for (std::size_t s = 1; s <= count; ++s) text += fmt::format("{0} 0 0 0 1 1 1 1 {0} 0\n", s);
    text += fmt::format("1 0 0 0 1 1 1 1 {0} 0\n$EndEntities\n$Nodes\n1 {1} 1 {1}\n2 1 0 {1}\n", count + 1, nodes);
    for (std::size_t n = 1; n <= nodes; ++n) text += fmt::format("{}\n", n);
    for (const auto& [x, y] : places) text += fmt::format("{:.17g} {:.17g} 0\n", x, y);
    auto elements = static_cast<std::size_t>(across * up);
    for (const auto& surface : surfaces) elements += surface.second.size();
    text += fmt::format("$EndNodes\n$Elements\n{0} {1} 1 {1}\n", count + 1, elements);
    int tag = 0;
    for (std::size_t s = 0; s < count; ++s) {
      text += fmt::format("1 {} 1 {}\n", s + 1, surfaces[s].second.size());
      for (const auto& [p, q] : surfaces[s].second) text += fmt::format("{} {} {}\n", ++tag, p, q);
    }
    text += fmt::format("2 1 3 {}\n", across * up);
    for (int j = 0; j < up; ++j)
      for (int i = 0; i < across; ++i)
        text += fmt::format("{} {} {} {} {}\n", ++tag, node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1));
    return text + "$EndElements\n";
  }

 private:
  [[nodiscard]] Edges along_first(int j) const {
    Edges edges;
    for (int i = 0; i < across; ++i) edges.emplace_back(node(i, j), node(i + 1, j));
    return edges;
  }
  [[nodiscard]] Edges along_second(int i) const {
    Edges edges;
    for (int j = 0; j < up; ++j) edges.emplace_back(node(i, j), node(i, j + 1));
    return edges;
  }
};

inline PlaneGrid::Edges operator+(PlaneGrid::Edges x, const PlaneGrid::Edges& y) {
  x.insert(x.end(), y.begin(), y.end());
  return x;
}

/// A rectangle whose low side is the parabola of a circle of `radius_m` (0: straight), lowest in its middle or, with
/// `from_axis`, at its left end.
inline PlaneGrid rectangle(double x0, double x1, double y0, double y1, int across, int up, double radius_m = 0.0,
                           bool from_axis = false) {
  return PlaneGrid(across, up, [&](double a, double b) {
    const double x = x0 + (x1 - x0) * a, off = x - (from_axis ? x0 : 0.5 * (x0 + x1)),
                 low = y0 + (radius_m > 0.0 ? off * off / (2.0 * radius_m) : 0.0);
    return PlaneGrid::Place(x, low + (y1 - low) * b);
  });
}

/// On rays from the middle of the unit disc outwards, -1 <= a, b <= 1: the square's sides become the circle.
inline PlaneGrid::Place on_rays(double a, double b, double inside) {
  const double out = std::max(std::abs(a), std::abs(b)), quarter = std::numbers::pi / 4.0;
  double across = 0.0, up = 0.0;
  if (out > 0.0 && std::abs(a) >= std::abs(b)) {
    across = std::copysign(out * std::cos(quarter * b / a), a);
    up = std::copysign(out, a) * std::sin(quarter * b / a);
  } else if (out > 0.0) {
    up = std::copysign(out * std::cos(quarter * a / b), b);
    across = std::copysign(out, b) * std::sin(quarter * a / b);
  }
  return {(1.0 - out) * inside * a + out * across, (1.0 - out) * inside * b + out * up};
}

/// A disc, and the upper or lower part of its circle as the surface "cap".
inline std::string disc_msh(const std::string& body, double x, double y, double radius_m, int cells, bool upper) {
  const PlaneGrid disc(cells, cells, [&](double a, double b) {
    const auto [across, rise] = on_rays(2.0 * a - 1.0, 2.0 * b - 1.0, 0.75);
    return PlaneGrid::Place(x + radius_m * across, y + radius_m * rise);
  });
  PlaneGrid::Edges cap;
  for (const auto& [p, q] : disc.low() + disc.right() + disc.high() + disc.left()) {
    const double rise = 0.5 * (disc.places[static_cast<std::size_t>(p - 1)].second +
                               disc.places[static_cast<std::size_t>(q - 1)].second) -
                        y;
    if ((upper ? rise : -rise) > 0.2 * radius_m) cap.emplace_back(p, q);
  }
  return disc.msh(body, {{"cap", cap}});
}

/// A disc with its whole circle as the surface "rim".
inline std::string whole_disc_msh(const std::string& body, double x, double y, double radius_m, int cells) {
  const PlaneGrid disc(cells, cells, [&](double a, double b) {
    const auto [across, rise] = on_rays(2.0 * a - 1.0, 2.0 * b - 1.0, 0.75);
    return PlaneGrid::Place(x + radius_m * across, y + radius_m * rise);
  });
  return disc.msh(body, {{"rim", disc.low() + disc.right() + disc.high() + disc.left()}});
}

/// A rectangle about (x, y), turned by an angle; its whole outline is the surface "rim", its sides are "low" and
/// "high".
inline std::string brick_msh(const std::string& body, double x, double y, double width_m, double height_m, int across,
                             int up, double angle_rad = 0.0) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const PlaneGrid brick(across, up, [&](double a, double b) {
    const double p = (a - 0.5) * width_m, q = (b - 0.5) * height_m;
    return PlaneGrid::Place(x + c * p - s * q, y + s * p + c * q);
  });
  return brick.msh(body, {{"rim", brick.low() + brick.right() + brick.high() + brick.left()},
                          {"low", brick.low()},
                          {"high", brick.high()}});
}

}  // namespace ricochet::test
