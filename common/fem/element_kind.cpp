#include "common/fem/element_kind.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/fem/bar.hpp"
#include "common/fem/hexahedron.hpp"
#include "common/fem/quadrilateral.hpp"
#include "common/fem/tetrahedron.hpp"
#include "common/fem/triangle.hpp"

namespace ricochet::fem {
namespace {

constexpr NodePair bar_edges[] = {{0, 1}};
constexpr Face bar_faces[] = {{0}, {1}};
constexpr NodePair triangle_edges[] = {{0, 1}, {1, 2}, {2, 0}}, triangle_diagonals[] = {{0, 1}, {0, 2}};
constexpr Face triangle_faces[] = {{0, 1}, {1, 2}, {2, 0}};
constexpr NodePair quadrilateral_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
                   quadrilateral_diagonals[] = {{0, 2}, {1, 3}};
constexpr Face quadrilateral_faces[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
constexpr NodePair tetrahedron_edges[] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}},
                   tetrahedron_diagonals[] = {{0, 1}, {0, 2}, {0, 3}};
constexpr Face tetrahedron_faces[] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
constexpr NodePair hexahedron_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                         {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}},
                   hexahedron_diagonals[] = {{0, 6}, {1, 7}, {3, 5}};
constexpr Face hexahedron_faces[] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                     {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
const NaturalPoint bar_corner[] = {{-1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
const NaturalPoint triangle_corner[] = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
const NaturalPoint quadrilateral_corner[] = {{-1.0, -1.0, 0.0}, {1.0, -1.0, 0.0}, {1.0, 1.0, 0.0}, {-1.0, 1.0, 0.0}};
const NaturalPoint tetrahedron_corner[] = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
const NaturalPoint hexahedron_corner[] = {{-1.0, -1.0, -1.0}, {1.0, -1.0, -1.0}, {1.0, 1.0, -1.0}, {-1.0, 1.0, -1.0},
                                          {-1.0, -1.0, 1.0},  {1.0, -1.0, 1.0},  {1.0, 1.0, 1.0},  {-1.0, 1.0, 1.0}};

/// In the order of ElementKind.
const ElementTraits table[] = {
    {.dimension = 1,
     .nodes = 2,
     .edges = bar_edges,
     .faces = bar_faces,
     .diagonals = bar_edges,
     .corner = bar_corner,
     .centre = {0.0, 0.0, 0.0},
     .gmsh_type = 1,
     .vtk_type = 3,
     .stiffness = bar_stiffness,
     .volume = bar_volume,
     .stress = bar_stress,
     .jacobian = bar_jacobian,
     .points = bar_points},
    {.dimension = 2,
     .nodes = 3,
     .edges = triangle_edges,
     .faces = triangle_faces,
     .diagonals = triangle_diagonals,
     .corner = triangle_corner,
     .centre = {1.0 / 3.0, 1.0 / 3.0, 0.0},
     .gmsh_type = 2,
     .vtk_type = 5,
     .stiffness = triangle_stiffness,
     .volume = triangle_volume,
     .stress = triangle_stress,
     .jacobian = triangle_jacobian,
     .points = nullptr},
    {.dimension = 2,
     .nodes = 4,
     .edges = quadrilateral_edges,
     .faces = quadrilateral_faces,
     .diagonals = quadrilateral_diagonals,
     .corner = quadrilateral_corner,
     .centre = {0.0, 0.0, 0.0},
     .gmsh_type = 3,
     .vtk_type = 9,
     .stiffness = quadrilateral_stiffness,
     .volume = quadrilateral_volume,
     .stress = quadrilateral_stress,
     .jacobian = quadrilateral_jacobian,
     .points = quadrilateral_points},
    {.dimension = 3,
     .nodes = 4,
     .edges = tetrahedron_edges,
     .faces = tetrahedron_faces,
     .diagonals = tetrahedron_diagonals,
     .corner = tetrahedron_corner,
     .centre = {0.25, 0.25, 0.25},
     .gmsh_type = 4,
     .vtk_type = 10,
     .stiffness = tetrahedron_stiffness,
     .volume = tetrahedron_volume,
     .stress = tetrahedron_stress,
     .jacobian = tetrahedron_jacobian,
     .points = nullptr},
    {.dimension = 3,
     .nodes = 8,
     .edges = hexahedron_edges,
     .faces = hexahedron_faces,
     .diagonals = hexahedron_diagonals,
     .corner = hexahedron_corner,
     .centre = {0.0, 0.0, 0.0},
     .gmsh_type = 5,
     .vtk_type = 12,
     .stiffness = hexahedron_stiffness,
     .volume = hexahedron_volume,
     .stress = hexahedron_stress,
     .jacobian = hexahedron_jacobian,
     .points = hexahedron_points},
};

}  // namespace

Face from_smallest(const Face& face) {
  if (face.size() < 3) return face;
  Face turned{};
  const auto first = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
  for (std::size_t i = 0; i < face.size(); ++i) turned.push_back(face[(first + i) % face.size()]);
  return turned;
}

Face sorted(const Face& face) {
  Face ascending = face;
  for (int* end = ascending.begin(); end != ascending.end(); ++end) {  // std::sort makes GCC 12 warn of other sizes
    for (int* node = end; node != ascending.begin() && node[-1] > node[0]; --node) std::swap(node[-1], node[0]);
  }
  return ascending;
}

const ElementTraits& traits(ElementKind kind) { return table[static_cast<std::size_t>(kind)]; }

std::optional<ElementKind> kind_of_gmsh_type(int type) {
  for (std::size_t i = 0; i < std::size(table); ++i) {
    if (table[i].gmsh_type == type) return static_cast<ElementKind>(i);
  }
  return std::nullopt;
}

}  // namespace ricochet::fem
