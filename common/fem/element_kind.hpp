#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "common/fem/model.hpp"

/// Says what an element is, apart from the model (model.hpp) that says which strains it has.
namespace ricochet::fem {

enum class ElementKind : unsigned char { bar, triangle, quadrilateral, tetrahedron, hexahedron };

/// Numbers of the nodes of one element, as many as its kind has. Plane kinds are numbered counter-clockwise, a bar
/// along x; a hexahedron has its first four nodes counter-clockwise seen from inside and the others above them, of a
/// tetrahedron the first three are counter-clockwise seen from the fourth (Gmsh's and VTK's order).
struct Element {
  static constexpr int most_nodes = 8;

  ElementKind kind = ElementKind::bar;
  std::array<int, most_nodes> node{};  ///< those beyond the kind's are 0 and mean nothing

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] int operator[](std::size_t i) const { return node[i]; }
  [[nodiscard]] const int* begin() const { return node.data(); }
  [[nodiscard]] const int* end() const { return node.data() + size(); }
  [[nodiscard]] int* begin() { return node.data(); }
  [[nodiscard]] int* end() { return node.data() + size(); }
  bool operator==(const Element&) const = default;
};

/// One row per node, two columns, three of a solid [m].
using ElementCoordinates = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Element::most_nodes, 3>;
using ElementMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3 * Element::most_nodes, 3 * Element::most_nodes>;
using ElementVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * Element::most_nodes, 1>;
using StressVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
using NaturalPoint = Eigen::Vector3d;  ///< (xi, eta, zeta); a bar reads xi alone, a plane kind the first two

/// A point of quadrature of an element that may yield.
struct ElementPoint {
  /// A row per node [1/m]: N_i,x N_i,y and N_i,z of a solid, in axisymmetry N_i,r N_i,z N_i/r; else the rest is 0.
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, Element::most_nodes, 3> gradient;
  double volume_m3;
};

using NodePair = std::array<int, 2>;  ///< an element's own node numbers

/// Nodes of a face, in the order that has the body behind it: one, the end of a bar; two, an edge with the body to its
/// left; three or four, counter-clockwise seen from outside.
class Face {
 public:
  constexpr Face(std::initializer_list<int> nodes) {
    for (const int node : nodes) push_back(node);
  }
  constexpr void push_back(int node) { node_[static_cast<std::size_t>(size_++)] = node; }
  [[nodiscard]] constexpr std::size_t size() const { return static_cast<std::size_t>(size_); }
  [[nodiscard]] constexpr int operator[](std::size_t i) const { return node_[i]; }
  [[nodiscard]] constexpr const int* begin() const { return node_.data(); }
  [[nodiscard]] constexpr const int* end() const { return node_.data() + size_; }
  [[nodiscard]] constexpr int* begin() { return node_.data(); }
  [[nodiscard]] constexpr int* end() { return node_.data() + size_; }
  friend bool operator==(const Face& x, const Face& y) { return std::equal(x.begin(), x.end(), y.begin(), y.end()); }
  friend bool operator<(const Face& x, const Face& y) {
    return std::lexicographical_compare(x.begin(), x.end(), y.begin(), y.end());
  }

 private:
  std::array<int, 4> node_{-1, -1, -1, -1};
  int size_ = 0;
};

/// The same face of a solid begun at its smallest node, so that equal faces are equal; an edge as it is.
[[nodiscard]] Face from_smallest(const Face& face);
/// Its nodes in ascending order: the same whatever its direction.
[[nodiscard]] Face sorted(const Face& face);

/// One row per kind: all that the rest of the program asks of a kind. A new kind is a file with its functions, a row in
/// element_kind.cpp, and nothing else, while its faces are nodes, straight edges, triangles or quadrilaterals.
struct ElementTraits {
  int dimension;                    ///< of the space it fills
  int nodes;                        ///< most Element::most_nodes
  std::span<const NodePair> edges;  ///< pairs of neighbouring nodes
  std::span<const Face> faces;      ///< where it ends, in the element's own node numbers
  std::span<const NodePair>
      diagonals;  ///< pairs whose differences give its mean displacement gradient, one a dimension
  std::span<const NaturalPoint> corner;  ///< natural coordinates of the nodes
  NaturalPoint centre;
  int gmsh_type;           ///< https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format
  unsigned char vtk_type;  ///< https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
  /// The functions of element.hpp; stiffness and stress are given matrix_places, the others the places as they are.
  ElementMatrix (*stiffness)(const Section&, const Material&, const ElementCoordinates&);
  Eigen::VectorXd (*volume)(const Section&, const ElementCoordinates&);
  StressVector (*stress)(const Section&, const Material&, const ElementCoordinates&, const ElementVector&,
                         const NaturalPoint&);
  double (*jacobian)(const ElementCoordinates&, const NaturalPoint&);
  /// Null of a kind that must not yield, since plastic flow keeps the volume, and its few points then lock it.
  std::vector<ElementPoint> (*points)(const Section&, const ElementCoordinates&);
};

[[nodiscard]] const ElementTraits& traits(ElementKind kind);

/// The kind that Gmsh numbers so; none if no element here is of that kind.
[[nodiscard]] std::optional<ElementKind> kind_of_gmsh_type(int type);

inline std::size_t Element::size() const { return static_cast<std::size_t>(traits(kind).nodes); }

}  // namespace ricochet::fem
