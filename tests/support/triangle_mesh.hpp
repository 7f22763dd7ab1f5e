#pragma once

#include <fmt/format.h>

#include <string>

namespace ricochet::test {

/// A rectangle [0, width] x [start, start + length], cut into cells.
struct Rectangle {
  double width_m = 1.0, start_m = 0.0, length_m = 1.0;
  int across = 1, along = 1;
};

/// MSH 4.1 text of a rectangle whose cells are two triangles each, their diagonals to either side in turn, every third
/// triangle clockwise; the last cell stays a quadrilateral. Physical surface `body`, curves "start", "end", "inner",
/// "outer" as a structured mesh has them.
inline std::string rectangle_msh(const std::string& body, const Rectangle& r) {
  const int columns = r.across + 1, rows = r.along + 1;
  const auto node = [&](int i, int j) { return j * columns + i + 1; };
  std::string text =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n5\n1 1 \"start\"\n1 2 \"end\"\n1 3 \"inner\"\n"
      "1 4 \"outer\"\n2 5 \"" +
      body + "\"\n$EndPhysicalNames\n$Entities\n0 4 1 0\n";
  for (int curve = 1; curve <= 4; ++curve) text += fmt::format("{} 0 0 0 1 1 0 1 {} 0\n", curve, curve);
  text += "1 0 0 0 1 1 0 1 5 0\n$EndEntities\n";
  text += fmt::format("$Nodes\n1 {0} 1 {0}\n2 1 0 {0}\n", columns * rows);
  for (int n = 1; n <= columns * rows; ++n) text += fmt::format("{}\n", n);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      text += fmt::format("{:.17g} {:.17g} 0\n", r.width_m * i / r.across, r.start_m + r.length_m * j / r.along);
  std::string triangles, curves[4];
  int tag = 0;
  const auto line = [&](int curve, int a, int b) { curves[curve] += fmt::format("{} {} {}\n", ++tag, a, b); };
  for (int i = 0; i < r.across; ++i) {
    line(0, node(i, 0), node(i + 1, 0));
    line(1, node(i, r.along), node(i + 1, r.along));
  }
  for (int j = 0; j < r.along; ++j) {
    line(2, node(0, j), node(0, j + 1));
    line(3, node(r.across, j), node(r.across, j + 1));
  }
  const auto triangle = [&](int a, int b, int c) {
    ++tag;
    triangles += tag % 3 == 0 ? fmt::format("{} {} {} {}\n", tag, a, c, b) : fmt::format("{} {} {} {}\n", tag, a, b, c);
  };
  for (int j = 0; j < r.along; ++j) {
    for (int i = 0; i < r.across; ++i) {
      if (i == r.across - 1 && j == r.along - 1) continue;
      const int a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
      triangle(a, b, (i + j) % 2 == 0 ? c : d);
      triangle((i + j) % 2 == 0 ? a : b, c, d);
    }
  }
  ++tag;
  text += fmt::format("$EndNodes\n$Elements\n6 {0} 1 {0}\n", tag);
  for (int curve = 0; curve < 4; ++curve)
    text += fmt::format("1 {} 1 {}\n{}", curve + 1, curve < 2 ? r.across : r.along, curves[curve]);
  text += fmt::format("2 1 2 {}\n{}", 2 * r.across * r.along - 2, triangles);
  text += fmt::format("2 1 3 1\n{} {} {} {} {}\n$EndElements\n", tag, node(r.across - 1, r.along - 1),
                      node(r.across, r.along - 1), node(r.across, r.along), node(r.across - 1, r.along));
  return text;
}

}  // namespace ricochet::test
