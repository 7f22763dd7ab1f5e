#include "common/fem/element_kind.hpp"

#include <iterator>

#include "common/fem/bar.hpp"
#include "common/fem/quadrilateral.hpp"
#include "common/fem/triangle.hpp"

namespace ricochet::fem {
namespace {

constexpr NodePair bar_edges[] = {{0, 1}}, bar_faces[] = {{0, 0}, {1, 1}};
constexpr NodePair triangle_edges[] = {{0, 1}, {1, 2}, {2, 0}}, triangle_diagonals[] = {{0, 1}, {0, 2}};
constexpr NodePair quadrilateral_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
                   quadrilateral_diagonals[] = {{0, 2}, {1, 3}};
const NaturalPoint bar_corner[] = {{-1.0, 0.0}, {1.0, 0.0}};
const NaturalPoint triangle_corner[] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
const NaturalPoint quadrilateral_corner[] = {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}};

/// In the order of ElementKind.
const ElementTraits table[] = {
    {.dimension = 1,
     .nodes = 2,
     .edges = bar_edges,
     .faces = bar_faces,
     .diagonals = bar_edges,
     .corner = bar_corner,
     .centre = {0.0, 0.0},
     .gmsh_type = 1,
     .vtk_type = 3,
     .stiffness = bar_stiffness,
     .volume = bar_volume,
     .stress = bar_stress,
     .jacobian = bar_jacobian},
    {.dimension = 2,
     .nodes = 3,
     .edges = triangle_edges,
     .faces = triangle_edges,
     .diagonals = triangle_diagonals,
     .corner = triangle_corner,
     .centre = {1.0 / 3.0, 1.0 / 3.0},
     .gmsh_type = 2,
     .vtk_type = 5,
     .stiffness = triangle_stiffness,
     .volume = triangle_volume,
     .stress = triangle_stress,
     .jacobian = triangle_jacobian},
    {.dimension = 2,
     .nodes = 4,
     .edges = quadrilateral_edges,
     .faces = quadrilateral_edges,
     .diagonals = quadrilateral_diagonals,
     .corner = quadrilateral_corner,
     .centre = {0.0, 0.0},
     .gmsh_type = 3,
     .vtk_type = 9,
     .stiffness = quadrilateral_stiffness,
     .volume = quadrilateral_volume,
     .stress = quadrilateral_stress,
     .jacobian = quadrilateral_jacobian},
};

}  // namespace

const ElementTraits& traits(ElementKind kind) { return table[static_cast<std::size_t>(kind)]; }

std::optional<ElementKind> kind_of_gmsh_type(int type) {
  for (std::size_t i = 0; i < std::size(table); ++i) {
    if (table[i].gmsh_type == type) return static_cast<ElementKind>(i);
  }
  return std::nullopt;
}

}  // namespace ricochet::fem
