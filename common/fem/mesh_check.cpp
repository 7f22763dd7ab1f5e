#include "common/fem/mesh_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/fem/part.hpp"

namespace ricochet::fem {
namespace {

// Below this share of the longest edge (squared) round-off in the coordinates decides the sign of det J.
constexpr double smallest_relative_determinant = 1e-10;

// Beyond, rounding of the coordinates changes lengths, masses and stiffness by more than 1e-8.
constexpr double furthest = 1e7;

std::string place(const Mesh& mesh, const ElementCoordinates& x) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  centre.head(x.cols()) = x.colwise().mean().transpose();
  if (mesh.model == Model::bar) return fmt::format("at x = {:.6g} m", centre[0]);
  const char* axes = mesh.model == Model::axisymmetric ? "(r, z)" : mesh.model == Model::solid ? "(x, y, z)" : "(x, y)";
  return fmt::format("at {} = {}", axes, place_text(mesh.model, centre));
}

/// det J of a plane element is linear in each natural coordinate, so its smallest value is at a corner. That of a
/// hexahedron, quadratic in each, is looked at where its integrals are, too: at its corners and between them and the
/// middle.
double smallest_determinant(const ElementGeometry& element) {
  const ElementTraits& kind = traits(element.kind);
  double smallest = std::numeric_limits<double>::infinity();
  const auto look = [&](const NaturalPoint& at) { smallest = std::min(smallest, kind.jacobian(element.x, at)); };
  for (const NaturalPoint& corner : kind.corner) {
    look(corner);
    if (element.kind == ElementKind::hexahedron) look(corner / std::sqrt(3.0));
  }
  return smallest;
}

/// Names a place so far from the origin that its coordinates have too few digits left for the size of the element.
std::optional<std::string> far_away(const Mesh& mesh, const ElementCoordinates& x, double size) {
  const double distance = x.cwiseAbs().maxCoeff();
  if (distance <= furthest * size) return std::nullopt;
  return fmt::format(
      "of {:.3g} m lies {:.3g} m from the origin, allowed: at most {:.0e} times its size; move the mesh {}", size,
      distance, furthest, place(mesh, x));
}

bool has_repeated_node(const Element& nodes) {
  for (const int* node = nodes.begin(); node != nodes.end(); ++node) {
    if (std::find(nodes.begin(), node, *node) != node) return true;
  }
  return false;
}

}  // namespace

std::optional<std::string> element_defect(const Mesh& mesh, int element) {
  const ElementGeometry geometry = element_geometry(mesh, element);
  const ElementCoordinates& x = geometry.x;
  if (!x.allFinite()) return "has a coordinate that is not a finite number";
  if (has_repeated_node(mesh.elements[at(element)])) return "uses a node twice " + place(mesh, x);
  if (mesh.model == Model::bar) {
    if (!(x(1, 0) > x(0, 0))) return "has no positive length " + place(mesh, x);
    return far_away(mesh, x, x(1, 0) - x(0, 0));
  }
  if (mesh.model == Model::axisymmetric && x.col(0).minCoeff() < 0.0) {
    return fmt::format("reaches across the axis (r = {:.6g} m) {}", x.col(0).minCoeff(), place(mesh, x));
  }
  const double edge = edge_lengths(geometry).longest;
  if (auto defect = far_away(mesh, x, edge)) return defect;
  const bool solid = mesh.model == Model::solid;
  const double size = solid ? edge * edge * edge : edge * edge;
  if (!(smallest_determinant(geometry) > smallest_relative_determinant * size)) {
    return fmt::format("is inverted, not convex or has no {} {}", solid ? "volume" : "area", place(mesh, x));
  }
  return std::nullopt;
}

void check_mesh(const Mesh& mesh, const std::string& body) {
  if (mesh.elements.empty()) throw ConfigError(fmt::format("body \"{}\": the mesh has no elements", body));
  for (std::size_t node = 0; node < mesh.position.size(); ++node) {
    if (mesh.position[node].allFinite()) continue;
    throw ConfigError(fmt::format("body \"{}\": a coordinate of node {} is not a finite number", body, node));
  }
  for (int element = 0; element < static_cast<int>(mesh.elements.size()); ++element) {
    const auto defect = element_defect(mesh, element);
    if (defect) throw ConfigError(fmt::format("body \"{}\": element {} {}", body, element, *defect));
  }
}

}  // namespace ricochet::fem
