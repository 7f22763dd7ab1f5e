#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

#include "common/fem/element_kind.hpp"
#include "common/surface/plane_polygon.hpp"

namespace ricochet::surface {

/// A face of a surface in its place: an edge, a triangle or a quadrilateral.
struct SurfaceFace {
  fem::Face node;
  std::array<Eigen::Vector3d, 4> x;  ///< of its nodes [m]
  std::array<double, 4> measure{};   ///< at them: area per length of an edge [m], thickness or circumference; else 1
  Eigen::Vector3d normal;            ///< out of the body
  /// Normal of the surface at the nodes; zero: the face is flat.
  std::array<Eigen::Vector3d, 4> node_normal{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                             Eigen::Vector3d::Zero()};
  std::array<unsigned, 4> held{};  ///< of the nodes: bits of the coordinates that no normal there has a part along
  std::array<bool, 4> sharp{};     ///< of the nodes: the smooth piece ends there, and no plane of symmetry
  int patch = 0;                   ///< smooth piece of the surface
  /// Thickness of the body behind it, to where the same surface bounds it again; infinite where that ends before.
  double thickness_m = std::numeric_limits<double>::infinity();
};

/// Faces of surfaces that go around their bodies also have their fronts towards each other where the bodies turn their
/// backs on each other: one of the bodies lies between them, or both. None can be so deep in the other.
[[nodiscard]] double most_depth_m(double thickness_m, double other_thickness_m);

/// Whether a smooth piece of the surface ends at the rim of a face, or of one of these faces, but for planes of
/// symmetry.
[[nodiscard]] bool has_edge(const SurfaceFace& face);
[[nodiscard]] bool has_edges(const std::vector<SurfaceFace>& faces);

/// The place of the smooth surface (mortar.hpp) where a face's shape functions have these values, and its normal there.
[[nodiscard]] Eigen::Vector3d place_at(const SurfaceFace& face, const ShapeValues& shape);
[[nodiscard]] Eigen::Vector3d normal_at(const SurfaceFace& face, const ShapeValues& shape);

/// A place so far beside a face or an edge, in shares of it, lies on it: between two of them round-off would find
/// neither.
constexpr double same_place = 1e-9;

/// Where a ray hits the smooth surface of a face or, by its shape functions, what goes on beside it.
struct Hit {
  double inside;  ///< the least shape function, at most 0; -infinity: the ray meets nothing
  double far_m;
  ShapeValues shape = ShapeValues::Zero();  ///< of the face there
};
[[nodiscard]] Hit hit_of(const Eigen::Vector3d& place, const Eigen::Vector3d& along, const SurfaceFace& face);

}  // namespace ricochet::surface
