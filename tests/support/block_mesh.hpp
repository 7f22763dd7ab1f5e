#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace ricochet::test {

/// A block [0, size] x [0, size] x [start, start + length] of cells.
struct BlockMesh {
  double size_m = 1.0, start_m = 0.0, length_m = 1.0;
  int across = 1, along = 1;
  bool tetrahedra = false;
};

/// MSH 4.1 text of a block of hexahedra, or of six tetrahedra around a diagonal of each; every third element is inside
/// out. Physical volume `body`, surfaces "start" and "end" (low and high z) and "sides" (the other four).
inline std::string block_msh(const std::string& body, const BlockMesh& b) {
  const int row = b.across + 1, layer = row * row, nodes = layer * (b.along + 1);
  std::string text =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"start\"\n2 2 \"end\"\n2 3 \"sides\"\n3 4 \"" +
      body + "\"\n$EndPhysicalNames\n$Entities\n0 0 3 1\n";
  for (int surface = 1; surface <= 3; ++surface) text += fmt::format("{0} 0 0 0 1 1 1 1 {0} 0\n", surface);
  text += fmt::format("1 0 0 0 1 1 1 1 4 0\n$EndEntities\n$Nodes\n1 {0} 1 {0}\n3 1 0 {0}\n", nodes);
  for (int n = 1; n <= nodes; ++n) text += fmt::format("{}\n", n);
  for (int n = 0; n < nodes; ++n)
    text += fmt::format("{:.17g} {:.17g} {:.17g}\n", b.size_m * (n % row) / b.across,
                        b.size_m * (n % layer / row) / b.across, b.start_m + b.length_m * (n / layer) / b.along);
  int tag = 0;
  std::array<std::string, 4> lines;  // of the three surfaces and the volume
  std::array<int, 4> count{};
  const auto add = [&](std::size_t entity, const std::vector<int>& element) {
    ++count[entity];
    lines[entity] += fmt::format("{} {}\n", ++tag, fmt::join(element, " "));
  };
  const auto add_face = [&](std::size_t entity, int p, int q, int r, int s) {  // p and r on the diagonal of its cell
    if (b.tetrahedra) {
      add(entity, {p, q, r});
      add(entity, {p, r, s});
    } else {
      add(entity, {p, q, r, s});
    }
  };
  for (int cell = 0; cell < b.across * b.across * b.along; ++cell) {
    const int i = cell % b.across, j = cell / b.across % b.across, k = cell / (b.across * b.across);
    const int n = 1 + k * layer + j * row + i;
    const int h[8] = {n, n + 1, n + row + 1, n + row, n + layer, n + layer + 1, n + layer + row + 1, n + layer + row};
    if (k == 0) add_face(0, h[0], h[1], h[2], h[3]);
    if (k == b.along - 1) add_face(1, h[4], h[5], h[6], h[7]);
    if (j == 0) add_face(2, h[0], h[1], h[5], h[4]);
    if (i == b.across - 1) add_face(2, h[6], h[5], h[1], h[2]);
    if (j == b.across - 1) add_face(2, h[6], h[7], h[3], h[2]);
    if (i == 0) add_face(2, h[0], h[3], h[7], h[4]);
    const bool turned = cell % 3 == 2;
    if (!b.tetrahedra) {
      add(3, turned ? std::vector<int>{h[4], h[5], h[6], h[7], h[0], h[1], h[2], h[3]}
                    : std::vector<int>(std::begin(h), std::end(h)));
      continue;
    }
    const int around[7] = {h[1], h[2], h[3], h[7], h[4], h[5], h[1]};
    for (int t = 0; t < 6; ++t)
      add(3, turned ? std::vector<int>{h[6], around[t], around[t + 1], h[0]}
                    : std::vector<int>{h[0], around[t], around[t + 1], h[6]});
  }
  text += fmt::format("$EndNodes\n$Elements\n4 {0} 1 {0}\n", tag);
  for (std::size_t e = 0; e < 4; ++e)
    text += fmt::format("{} {} {} {}\n{}", e < 3 ? 2 : 3, e < 3 ? static_cast<int>(e) + 1 : 1,
                        (e < 3 ? 3 : 5) - (b.tetrahedra ? 1 : 0), count[e], lines[e]);
  return text + "$EndElements\n";
}

using Vector3 = std::array<double, 3>;

/// A turn about z, then about x [rad].
struct Turn {
  double about_z = 0.0, about_x = 0.0;

  [[nodiscard]] Vector3 of(const Vector3& v) const {
    const double c = std::cos(about_z), s = std::sin(about_z), y = s * v[0] + c * v[1];
    return {c * v[0] - s * v[1], std::cos(about_x) * y - std::sin(about_x) * v[2],
            std::sin(about_x) * y + std::cos(about_x) * v[2]};
  }
};

/// MSH text with the places of its nodes turned.
inline std::string turned(const std::string& msh, const Turn& turn) {
  std::istringstream lines(msh);
  std::string text, line;
  bool nodes = false;
  while (std::getline(lines, line)) {
    if (line[0] == '$') nodes = line == "$Nodes";
    Vector3 x;
    char rest = 0;
    if (nodes && std::sscanf(line.c_str(), "%lf %lf %lf %c", &x[0], &x[1], &x[2], &rest) == 3) {
      x = turn.of(x);
      line = fmt::format("{:.17g} {:.17g} {:.17g}", x[0], x[1], x[2]);
    }
    text += line + '\n';
  }
  return text;
}

}  // namespace ricochet::test
