#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "common/fem/model.hpp"

/// What an element is, apart from the model (model.hpp) that says which strains it has.
namespace ricochet::fem {

enum class ElementKind : unsigned char { bar, triangle, quadrilateral };

/// Numbers of the nodes of one element, as many as its kind has. Plane kinds are numbered counter-clockwise, a bar
/// along x.
struct Element {
  static constexpr int most_nodes = 4;

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

/// One row per node [m].
using ElementCoordinates = Eigen::Matrix<double, Eigen::Dynamic, 2, 0, Element::most_nodes, 2>;
using ElementMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * Element::most_nodes, 2 * Element::most_nodes>;
using ElementVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 * Element::most_nodes, 1>;
using StressVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1>;
using NaturalPoint = Eigen::Vector2d;  ///< (xi, eta); a bar reads xi alone

using NodePair = std::array<int, 2>;  ///< an element's own node numbers

/// One row per kind: all that the rest of the program asks of a kind. A new kind is a file with its functions, a row in
/// element_kind.cpp, and nothing else, while its faces are nodes or straight edges.
struct ElementTraits {
  int dimension;                    ///< of the space it fills
  int nodes;                        ///< most Element::most_nodes
  std::span<const NodePair> edges;  ///< pairs of neighbouring nodes
  std::span<const NodePair> faces;  ///< where it ends: edges with the element to the left; a bar's nodes, doubled
  std::span<const NodePair>
      diagonals;  ///< pairs whose differences give its mean displacement gradient, one a dimension
  std::span<const NaturalPoint> corner;  ///< natural coordinates of the nodes
  NaturalPoint centre;
  int gmsh_type;           ///< https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format
  unsigned char vtk_type;  ///< https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
  /// The functions of element.hpp.
  ElementMatrix (*stiffness)(const Section&, const Material&, const ElementCoordinates&);
  Eigen::VectorXd (*volume)(const Section&, const ElementCoordinates&);
  StressVector (*stress)(const Section&, const Material&, const ElementCoordinates&, const ElementVector&,
                         const NaturalPoint&);
  double (*jacobian)(const ElementCoordinates&, const NaturalPoint&);
};

[[nodiscard]] const ElementTraits& traits(ElementKind kind);

/// The kind that Gmsh numbers so; none if no element here is of that kind.
[[nodiscard]] std::optional<ElementKind> kind_of_gmsh_type(int type);

inline std::size_t Element::size() const { return static_cast<std::size_t>(traits(kind).nodes); }

}  // namespace ricochet::fem
