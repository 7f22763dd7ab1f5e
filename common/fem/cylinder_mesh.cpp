#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/fem/mesh.hpp"

namespace ricochet::fem {
namespace {

/// Lines of a cross section, as shares of the radius: the core's, on either side of the axis, and those of the rings.
struct Lines {
  std::vector<double> share;
  int core = 1;

  [[nodiscard]] double core_share() const { return share[at(core)]; }
};

/// By how much the sides of a core up to the share a of the radius are bent from straight (0) to a circle (1). With 0.4
/// its corner and the two ring elements beside it have nearly equal angles; where it reaches far out it is bent more,
/// so that at its corner the rings keep three quarters of their room.
double bend_of_core(double a) {
  const double diagonal = std::numbers::sqrt2,
               with_room = (diagonal * a - 1.0 + 0.75 * (1.0 - a)) / ((diagonal - 1.0) * a);
  return std::max(0.4, with_room);
}

/// Place at the share u of the radius, in the direction (1, t) of a square, 0 <= t <= 1, of a circle of radius 1. In
/// the core lines are bent more and more outwards; from its edge to the circle the way is straight.
Eigen::Vector2d place_in_octant(const Lines& lines, double u, double t) {
  const double a = lines.core_share(), angle = 0.25 * std::numbers::pi * t;
  const Eigen::Vector2d square(1.0, t);
  Eigen::Vector2d circle(std::cos(angle), std::sin(angle));
  if (t == 1.0) circle.setConstant(std::sqrt(0.5));
  const auto bent = [&](double bend) { return Eigen::Vector2d((1.0 - bend) * square + bend * circle); };
  if (u <= a) return u * bent(bend_of_core(a) * (u / a) * (u / a));
  const double outward = (u - a) / (1.0 - a);
  return (1.0 - outward) * a * bent(bend_of_core(a)) + outward * circle;
}

/// Place at the share u in the direction of the crossing of two core lines, numbered from the axis. The eight octants
/// are images of one.
Eigen::Vector2d place_of(const Lines& lines, double u, int i, int j) {
  const int far = std::max(std::abs(i), std::abs(j)), near = std::min(std::abs(i), std::abs(j));
  if (far == 0) return Eigen::Vector2d::Zero();
  Eigen::Vector2d place = place_in_octant(lines, u, lines.share[at(near)] / lines.share[at(far)]);
  if (std::abs(i) < std::abs(j)) std::swap(place[0], place[1]);
  return {i < 0 ? -place[0] : place[0], j < 0 ? -place[1] : place[1]};
}

/// The core's edge: crossings of its lines, counter-clockwise.
std::vector<std::array<int, 2>> edge_of_core(int core) {
  std::vector<std::array<int, 2>> edge;
  for (int k = -core; k < core; ++k) edge.push_back({core, k});
  for (int k = -core; k < core; ++k) edge.push_back({-k, core});
  for (int k = -core; k < core; ++k) edge.push_back({-core, -k});
  for (int k = -core; k < core; ++k) edge.push_back({k, -core});
  return edge;
}

/// Nodes and quadrilaterals of a cross section, these counter-clockwise.
struct CrossSection {
  std::vector<Eigen::Vector2d> place;
  std::vector<std::array<int, 4>> elements;
  std::vector<bool> on_rim;  ///< per node

  void add(const Eigen::Vector2d& x, bool rim) {
    place.push_back(x);
    on_rim.push_back(rim);
  }
};

void add_core(const Lines& lines, CrossSection& section) {
  const int c = lines.core, row = 2 * c + 1;
  const bool alone = lines.core_share() == 1.0;
  for (int j = -c; j <= c; ++j) {
    for (int i = -c; i <= c; ++i) {
      const int far = std::max(std::abs(i), std::abs(j));
      section.add(place_of(lines, lines.share[at(far)], i, j), alone && far == c);
    }
  }
  for (int j = 0; j < 2 * c; ++j) {
    for (int i = 0; i < 2 * c; ++i) {
      const int n = j * row + i;
      section.elements.push_back({n, n + 1, n + row + 1, n + row});
    }
  }
}

void add_rings(const Lines& lines, CrossSection& section) {
  const auto edge = edge_of_core(lines.core);
  std::vector<int> inner, outer;
  for (const auto& [i, j] : edge) inner.push_back((j + lines.core) * (2 * lines.core + 1) + i + lines.core);
  for (std::size_t line = at(lines.core) + 1; line < lines.share.size(); ++line) {
    outer.clear();
    for (const auto& [i, j] : edge) {
      outer.push_back(static_cast<int>(section.place.size()));
      section.add(place_of(lines, lines.share[line], i, j), line + 1 == lines.share.size());
    }
    for (std::size_t k = 0; k < edge.size(); ++k) {
      const std::size_t next = (k + 1) % edge.size();
      section.elements.push_back({inner[k], outer[k], outer[next], inner[next]});
    }
    inner.swap(outer);
  }
}

/// The faces of the hexahedron made last that end the body, by their places in its list of faces.
void add_faces(const std::vector<bool>& on_rim, bool first, bool last, Mesh& mesh) {
  const Element& element = mesh.elements.back();
  const auto add = [&](const char* surface, std::size_t number) {
    Face face = traits(element.kind).faces[number];
    for (int& node : face) node = element[at(node)];
    mesh.surfaces[surface].push_back(face);
  };
  const auto rim = [&](std::size_t i) { return on_rim[at(element[i]) % on_rim.size()]; };
  if (first) add("start", 0);
  if (last) add("end", 1);
  for (std::size_t side = 0; side < 4; ++side)
    if (rim(side) && rim((side + 1) % 4)) add("outer", 2 + side);
}

}  // namespace

int core_of_cylinder(int across) { return (across + 1) / 2; }

Mesh cylinder_mesh(const std::vector<double>& across, const std::vector<double>& along) {
  const double radius = across.back();
  Lines lines{across, core_of_cylinder(static_cast<int>(across.size()) - 1)};
  for (double& share : lines.share) share /= radius;
  CrossSection section;
  add_core(lines, section);
  add_rings(lines, section);
  Mesh mesh;
  mesh.model = Model::solid;
  for (const double z : along)
    for (const Eigen::Vector2d& x : section.place) mesh.position.emplace_back(radius * x[0], radius * x[1], z);
  const int layer = static_cast<int>(section.place.size()), layers = static_cast<int>(along.size()) - 1;
  for (int k = 0; k < layers; ++k) {
    for (const auto& [a, b, c, d] : section.elements) {
      const int low = k * layer, high = low + layer;
      mesh.elements.push_back(
          {ElementKind::hexahedron, {low + a, low + b, low + c, low + d, high + a, high + b, high + c, high + d}});
      add_faces(section.on_rim, k == 0, k == layers - 1, mesh);
    }
  }
  return mesh;
}

}  // namespace ricochet::fem
