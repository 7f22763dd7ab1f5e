#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

namespace ricochet::test {

/// A block of hexahedra over [x, size] x [y, size] between z and z + length, whose one end is the paraboloid of a
/// sphere of `radius_m` about the z axis: "cap", outwards if `up`, at its high end, else at its low one. Further
/// surfaces: "x0" and "y0", where x and y are smallest, and "rest".
struct DomeMesh {
  double size_m = 0.004, radius_m = 0.4, length_m = 0.004, start_m = 0.0;
  bool up = true;
  bool half_x = true, half_y = true;  ///< from the plane of symmetry on; else from -size, twice as many elements
  double slope_y = 0.0;               ///< of its ends, which rise along y
  int across = 4, along = 3;
};

/// MSH 4.1 text; physical volume `body`.
inline std::string dome_msh(const std::string& body, const DomeMesh& d) {
  const int nx = d.half_x ? d.across : 2 * d.across, ny = d.half_y ? d.across : 2 * d.across;
  const double x0 = d.half_x ? 0.0 : -d.size_m, y0 = d.half_y ? 0.0 : -d.size_m;
  const int row = nx + 1, layer = row * (ny + 1), nodes = layer * (d.along + 1);
  const std::array<const char*, 5> surfaces = {"cap", "base", "x0", "y0", "rest"};
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n6\n";
  for (std::size_t s = 0; s < 5; ++s) text += fmt::format("2 {} \"{}\"\n", s + 1, surfaces[s]);
  text += "3 6 \"" + body + "\"\n$EndPhysicalNames\n$Entities\n0 0 5 1\n";
  for (int s = 1; s <= 5; ++s) text += fmt::format("{0} 0 0 0 1 1 1 1 {0} 0\n", s);
  text += fmt::format("1 0 0 0 1 1 1 1 6 0\n$EndEntities\n$Nodes\n1 {0} 1 {0}\n3 1 0 {0}\n", nodes);
  for (int n = 1; n <= nodes; ++n) text += fmt::format("{}\n", n);
  for (int n = 0; n < nodes; ++n) {
    const double x = x0 + (d.size_m - x0) * (n % row) / nx, y = y0 + (d.size_m - y0) * (n % layer / row) / ny,
                 height = static_cast<double>(n / layer) / d.along, sag = (x * x + y * y) / (2.0 * d.radius_m);
    text +=
        fmt::format("{:.17g} {:.17g} {:.17g}\n", x, y,
                    d.start_m + d.slope_y * y + d.length_m * height + (d.up ? -sag * height : sag * (1.0 - height)));
  }
  int tag = 0;
  std::array<std::string, 6> lines;
  std::array<int, 6> count{};
  const auto add = [&](std::size_t entity, const std::vector<int>& element) {
    ++count[entity];
    lines[entity] += fmt::format("{} {}\n", ++tag, fmt::join(element, " "));
  };
  for (int cell = 0; cell < nx * ny * d.along; ++cell) {
    const int i = cell % nx, j = cell / nx % ny, k = cell / (nx * ny), n = 1 + k * layer + j * row + i;
    const int h[8] = {n, n + 1, n + row + 1, n + row, n + layer, n + layer + 1, n + layer + row + 1, n + layer + row};
    if (k == 0) add(d.up ? 1 : 0, {h[0], h[3], h[2], h[1]});
    if (k == d.along - 1) add(d.up ? 0 : 1, {h[4], h[5], h[6], h[7]});
    if (i == 0) add(2, {h[0], h[4], h[7], h[3]});
    if (j == 0) add(3, {h[0], h[1], h[5], h[4]});
    if (i == nx - 1) add(4, {h[1], h[2], h[6], h[5]});
    if (j == ny - 1) add(4, {h[2], h[3], h[7], h[6]});
    add(5, std::vector<int>(std::begin(h), std::end(h)));
  }
  text += fmt::format("$EndNodes\n$Elements\n6 {0} 1 {0}\n", tag);
  for (std::size_t e = 0; e < 6; ++e)
    text += fmt::format("{} {} {} {}\n{}", e < 5 ? 2 : 3, e < 5 ? static_cast<int>(e) + 1 : 1, e < 5 ? 3 : 5, count[e],
                        lines[e]);
  return text + "$EndElements\n";
}

}  // namespace ricochet::test
