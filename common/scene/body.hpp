#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/fem/model.hpp"

/// The tables [[body]] of a scene: meshes, supports and loads.
namespace ricochet::scene {

using fem::Material;
using fem::Model;

/// Structured mesh. The *axis* is the last coordinate: x of a bar, y in plane strain, z in axisymmetry and of a solid.
/// Surfaces: "start" and "end" (low and high end of the axis); in two dimensions also "inner" and "outer" (of the first
/// coordinate), of a block those and "front" and "back" (of the second), of a solid cylinder "outer" alone.
struct StructuredMesh {
  double start_m = 0.0;   ///< axis coordinate of the low end
  double length_m = 0.0;  ///< extent along the axis
  double across_m = 0.0;  ///< `radius_m` (from r = 0, of a cylinder from x = y = 0) or `height_m` (from x = 0)
  double width_m = 0.0;   ///< block: extent along y, from y = 0
  bool cylinder = false;  ///< solid with `radius_m`; elements and grading across are those along a radius
  int elements_along = 0;
  int elements_across = 1;
  int elements_wide = 1;
  double grading_along = 1.0;  ///< size of the last element over size of the first, geometric in between
  double grading_across = 1.0;
  double grading_wide = 1.0;
  /// Plane strain: "outer" is "inner" moved by across_m; both surfaces vanish. Solid: "back" is "front" moved by
  /// width_m, too.
  bool periodic_across = false;

  [[nodiscard]] double elements_in_layer() const;  ///< between two cross sections
  [[nodiscard]] double nodes_in_layer() const;
};

/// Gmsh MSH 4.1 file; the physical surface (1D: curve, 3D: volume) named like the body holds its elements, other
/// physical groups name surfaces and element groups.
struct GmshMesh {
  std::string path;     ///< absolute, resolved against the scene file's folder
  double unit_m = 1.0;  ///< length of its unit
};

/// A part of a mesh whose elements are divided (fem::refine): those with their middle in a box of the mesh's own
/// coordinates.
struct RefinedBox {
  std::vector<double> from_m, to_m;  ///< one entry per component
  int ratio = 2;                     ///< elements along an edge of one that is divided
};

/// Where a mesh stands: turned about a point, then moved. A direction of its own coordinates becomes that of space.
struct MeshPlace {
  std::array<double, 3> turned_rad{};  ///< about the vector, by its length
  std::array<double, 3> about_m{}, moved_m{};

  [[nodiscard]] bool turned() const { return turned_rad != std::array<double, 3>{}; }
};

/// Piecewise linear factor over time, constant outside the given times. Empty: factor 1.
struct Amplitude {
  std::vector<double> time_s;
  std::vector<double> factor;
  [[nodiscard]] double at(double time_s) const;
};

struct Support {
  std::string surface;          ///< or a name for the node at `at_m`
  std::vector<int> components;  ///< fixed components, 0-based (scene: "x", "y", "r", "z")
  std::vector<double> at_m{};   ///< of one node: its place, an entry per component; empty: of a surface
};

struct Traction {
  std::string surface;
  std::vector<double> traction_pa;  ///< one entry per component, force per area of the reference surface
  Amplitude amplitude;
  double pressure_pa = 0.0;  ///< in place of them: against the outward normal of the reference surface
};

/// A turn about an axis through a point, of all components of what it holds: u = (R - 1)(X - about), R the rotation
/// about the vector turn_rad by its length times the amplitude.
struct PrescribedTurn {
  std::array<double, 3> turn_rad{};
  std::array<double, 3> about_m{};
};

struct PrescribedMotion {
  std::string surface;
  int component = 0;
  double displacement_m = 0.0;
  std::optional<PrescribedTurn> turn;  ///< in place of the displacement of a component
  Amplitude amplitude;
};

/// The long wave that an absorbing surface takes up, which fixes its speed along the surface's normal.
enum class Wave {
  bar,  ///< free sides: sqrt(E/rho) of bars and slender cylinders, sqrt(E/(rho (1 - nu^2))) of a plate in plane strain
  dilatational,  ///< no strain across: c_L (Eq. 26)
};

/// Dashpots in place of a continuation of the body.
struct AbsorbingSurface {
  std::string surface;
  Wave wave = Wave::bar;
};

/// A mesh of its own, for itself the body's or one of several that ties join.
struct MeshPiece {
  std::string name;  ///< empty: the body's only mesh
  std::variant<StructuredMesh, GmshMesh> elements;
  std::vector<RefinedBox> refine;                   ///< one after the other
  MeshPlace place;                                  ///< of the divided mesh
  std::optional<Material> material = std::nullopt;  ///< none: that of the body
};

/// A material of the elements of a group.
struct GroupMaterial {
  std::string group;
  Material material;
};

struct Body {
  std::string name;
  Material material;                             ///< of elements without one of their piece or group
  std::vector<GroupMaterial> groups;             ///< that have one
  double area_m2 = 1.0;                          ///< `bar`: cross section
  double thickness_m = 1.0;                      ///< `plane_strain`: thickness
  std::vector<MeshPiece> pieces;                 ///< one without a name, or all with one
  std::vector<std::array<std::string, 2>> ties;  ///< surfaces of pieces that move together, "PIECE.SURFACE"
  std::vector<double> initial_velocity_m_s;      ///< one entry per component
  bool rigid = false;           ///< moves as one, but for a strain that is the same everywhere (problem/rigid_body.cpp)
  bool large_rotation = false;  ///< a frame that turns with it: its elements strain little, but turn by any angle
  /// About its centre of mass, along the axes of space; zero unless large_rotation.
  std::array<double, 3> initial_angular_velocity_rad_s{};
  std::vector<double> initial_displacement_start_m;  ///< at the low end of the axis, linear along it
  std::vector<double> initial_displacement_end_m;    ///< at the high end of the axis
  std::vector<double> gravity_m_s2;                  ///< body force per unit mass, one entry per component
  std::vector<Support> supports;
  std::vector<Traction> tractions;
  std::vector<PrescribedMotion> prescribed;
  [[nodiscard]] bool told_to_turn() const {
    return std::any_of(prescribed.begin(), prescribed.end(), [](const auto& given) { return given.turn.has_value(); });
  }
  std::vector<AbsorbingSurface> absorbing;

  /// Its mesh if that is a structured one; null of pieces and of a file.
  [[nodiscard]] const StructuredMesh* structured() const;
  [[nodiscard]] std::vector<const GmshMesh*> files() const;
  [[nodiscard]] bool of_pieces() const { return !pieces.front().name.empty(); }
  /// All that its elements may have, each by what has it: "BODY", "BODY.PIECE" or "BODY.GROUP".
  [[nodiscard]] std::vector<std::pair<std::string, Material>> materials() const;
  /// Whether a material of it has plasticity; whether plastic work heats one.
  [[nodiscard]] bool yields() const;
  [[nodiscard]] bool heats() const;
};

/// The surface of all of a body's faces that no element shares; of one that turns, whose every side may touch.
inline constexpr const char* outside_surface = "outside";
[[nodiscard]] inline bool has_outside(const Body& body) { return body.large_rotation && !body.of_pieces(); }

/// A body that is a program of somebody else's alone: of it the scene knows where it is joined to one of its own, not
/// mesh, material, supports and loads. The nodes that it shares with that body are nodes of that body's mesh.
struct ForeignBody {
  std::string name;
  std::string joined_to;  ///< one of Scene::bodies
  /// All nodes of this surface of that body are shared; with a file of faces these lie on it; else empty.
  std::string surface;
  std::string interface_nodes;               ///< absolute path of the file; empty: the nodes of the surface
  std::vector<double> interface_position_m;  ///< of the file: per node one number per component
  /// Absolute path of the file of faces, by which the nodes need not be those of the other body; empty: they are.
  std::string interface_faces;
  std::vector<std::vector<int>> faces;  ///< of the file: indices of nodes
  std::optional<double> mass_kg;        ///< of the whole body, to be compared; empty: nothing is
};

}  // namespace ricochet::scene
