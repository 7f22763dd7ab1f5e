#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "common/fem/element_kind.hpp"
#include "common/fem/model.hpp"

namespace ricochet::fem {

constexpr int most_elements = 1'000'000;  ///< of a body

/// A node or element number as an index.
[[nodiscard]] inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A node with its share in a sum.
struct WeightedNode {
  int node = -1;
  double weight = 0.0;
};

/// A node of small elements on the edge or the face of a larger one, of one side of a tie or of a rigid body: it has no
/// motion of its own,
///   u = sum of weight u of its carriers,
/// and what acts on it acts on them by the same shares. None of them hangs, and weights sum to 1. On a larger element
/// they are >= 0, others need not be.
struct HangingNode {
  int node = -1;
  std::vector<WeightedNode> carriers;
  /// A tie gives weights >= 0 that sum to 1: to the face that the node lies in; to all nodes that share a face with it.
  std::vector<WeightedNode> between{}, beside{};
  /// Bits of the components that do not hang: a support or a prescribed motion has the node there, and not all of those
  /// that carry it.
  unsigned held = 0;

  /// Where dashpots and areas of contact go, which must not be negative and belong to that place.
  [[nodiscard]] const std::vector<WeightedNode>& bearers() const { return between.empty() ? carriers : between; }
  /// Where masses go: no node that the stiffness reaches is left without.
  [[nodiscard]] const std::vector<WeightedNode>& mass_bearers() const { return beside.empty() ? carriers : beside; }
  [[nodiscard]] bool hangs(int component) const { return (held >> component & 1U) == 0; }
};

/// Nodes, elements and named groups of one body.
/// Coordinates: bar (x, 0, 0); plane strain (x, y, 0); axisymmetric (r, z, 0); solid (x, y, z).
struct Mesh {
  Model model = Model::bar;
  std::vector<Eigen::Vector3d> position;  ///< [m]
  std::vector<Element> elements;
  std::map<std::string, std::vector<int>> element_groups;
  std::map<std::string, std::vector<Face>> surfaces;
  std::map<std::string, int> points;  ///< nodes with a name, for who asks for nodes as of a surface
  /// By the name of a foreign body with a mesh of its own at the interface: its nodes there, of no element here.
  std::map<std::string, std::vector<int>> foreign_nodes;
  std::vector<HangingNode> hanging;  ///< ascending by node
  int rigid_nodes = 0;               ///< of a rigid body: the last so many, of no element, on which all others hang
  std::vector<std::string> refined_surfaces;  ///< with faces of elements that were divided
  std::vector<Material> materials;            ///< of elements that have another one than the body
  std::vector<int> material;                  ///< per element: which of them, -1 the body's; empty: all have that
  double period_m = 0.0;  ///< > 0: the first coordinate repeats with this period, elements may reach across its end
  double period_wide_m = 0.0;  ///< of solids: the same of the second coordinate
};

/// Which of Mesh::materials an element has, -1: that of the body.
[[nodiscard]] inline int material_index(const Mesh& mesh, int element) {
  return mesh.material.empty() ? -1 : mesh.material[at(element)];
}

/// The material of an element of a part or of a whole body.
template <class Owner>
[[nodiscard]] const Material& material_of(const Owner& owner, int element) {
  const int index = material_index(owner.mesh, element);
  return index < 0 ? owner.material : owner.mesh.materials[at(index)];
}

/// All that its elements have, each once.
template <class Owner>
[[nodiscard]] std::vector<const Material*> materials_of(const Owner& owner) {
  std::vector<const Material*> all;
  for (std::size_t e = 0; e < owner.mesh.material.size(); ++e) {
    const Material* const own = &material_of(owner, static_cast<int>(e));
    if (std::find(all.begin(), all.end(), own) == all.end()) all.push_back(own);
  }
  if (all.empty()) all.push_back(&owner.material);
  return all;
}

/// `x`, or its periodic image, that lies within half a period of `reference` [m].
inline Eigen::Vector3d nearest_image(const Mesh& mesh, Eigen::Vector3d x, const Eigen::Vector3d& reference) {
  if (mesh.period_m > 0.0) x[0] -= mesh.period_m * std::round((x[0] - reference[0]) / mesh.period_m);
  if (mesh.period_wide_m > 0.0) x[1] -= mesh.period_wide_m * std::round((x[1] - reference[1]) / mesh.period_wide_m);
  return x;
}

/// Coordinate that runs along the axis, the last one (see scene::StructuredMesh) [m].
inline double axis_coordinate(Model model, const Eigen::Vector3d& x) { return x[components(model) - 1]; }

/// A place for texts, "(0.1, 0.2) m"; of a solid with all three coordinates.
[[nodiscard]] std::string place_text(Model model, const Eigen::Vector3d& x);

/// Geometric grading: `count` elements over `length` whose last is `grading` times as long as the first;
/// returns count + 1 coordinates starting at `start` [m]. Throws ConfigError for count < 1, length or grading not > 0.
[[nodiscard]] std::vector<double> graded_coordinates(double start, double length, int count, double grading);

/// Bar of `along.size() - 1` elements. Surfaces "start" and "end".
[[nodiscard]] Mesh bar_mesh(const std::vector<double>& along);

/// Quadrilaterals over the product of two coordinate lists. Surfaces "start", "end" (low, high second coordinate),
/// "inner", "outer" (low, high first coordinate).
[[nodiscard]] Mesh quadrilateral_mesh(Model model, const std::vector<double>& across, const std::vector<double>& along);

/// Hexahedra over the product of three coordinate lists. Surfaces "start", "end" (low, high z), "inner", "outer" (low,
/// high x), "front", "back" (low, high y).
[[nodiscard]] Mesh block_mesh(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z);

/// Hexahedra of a cylinder about the z axis, from its lines across, from 0 to the radius, and along z: a core of
/// quadrilaterals with rounded sides, of so many lines on either side of the axis, and rings around it. On the x and y
/// axes nodes have the coordinates of the lines; the outermost lie on the circle. The mesh is its own image under the
/// eight symmetries of the square. Surfaces "start", "end" (low, high z), "outer".
[[nodiscard]] Mesh cylinder_mesh(const std::vector<double>& across, const std::vector<double>& along);
[[nodiscard]] int core_of_cylinder(int across);

/// Nodes of a surface, each once, sorted by position (first coordinate, then second, then third), or the point of that
/// name. ConfigError if unknown.
[[nodiscard]] std::vector<int> surface_nodes(const Mesh& mesh, const std::string& surface);

/// Reads a Gmsh MSH 4.1 ASCII file [m]. Physical groups of dimension `d` (1 for bars, 3 for solids, else 2) become
/// element groups, those of dimension d - 1 surfaces; groups that hold nothing of `body` are left out. Only the
/// elements of group `body` are kept, in the file's order; nodes in ascending order of their tags. A clockwise element
/// is turned round, as is a solid one inside out and a face that does not have the body behind it; axisymmetric nodes
/// within 1e-9 of the radius are put on the axis. Throws ConfigError naming file and line for: another version, binary,
/// an unsupported element type, an element without a group, a missing group `body`, inverted, degenerate or overlapping
/// elements (named by tag), a surface inside the body, a file that ends early; naming file and tags for nodes off the
/// plane (bar: off the x axis) and for two nodes of the body at one place.
[[nodiscard]] Mesh read_gmsh(const std::string& path, Model model, const std::string& body);

/// Throws ConfigError naming the element and its position if the Jacobian is not positive everywhere in it (an
/// element that is inverted, not convex or without area; a bar without length), if r < 0 in axisymmetry, if a
/// number is not finite or if there is no element at all.
void check_mesh(const Mesh& mesh, const std::string& body);

}  // namespace ricochet::fem
