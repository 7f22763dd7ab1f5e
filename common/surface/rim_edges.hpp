#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/fem/mesh.hpp"
#include "common/surface/box_tree.hpp"
#include "common/surface/surface_face.hpp"

namespace ricochet::surface {

/// A convex edge of a solid's surface: two smooth pieces meet there, or one ends.
struct RimEdge {
  std::array<int, 2> node;                 ///< ascending
  std::array<Eigen::Vector3d, 2> x;        ///< of its nodes [m]
  std::array<Eigen::Vector3d, 2> outward;  ///< out of both faces; where there is one, also away from it in its plane
  double thickness_m;                      ///< of the thicker face
};

/// Where the lines through an edge of one surface and an edge of another are nearest, within both.
struct EdgeCrossing {
  std::vector<fem::WeightedNode> first, second;  ///< ascending by node
  int number;                                    ///< of this pair of edges, from 0
  Eigen::Vector3d normal;                        ///< across both, out of the first surface
  double gap_m;                                  ///< along it
  double area_m2;                                ///< a quarter of the product of their lengths
};

/// Edges of a surface in its place.
class RimEdges {
 public:
  RimEdges() : tree_({}) {}
  explicit RimEdges(const std::vector<SurfaceFace>& faces);

  /// Crossings of these edges, moved by `shift_m`, with those of `first`. The normal has parts along both outward
  /// directions of either edge: within `least_tilt` [rad] of one of them the edges lie in a face.
  [[nodiscard]] std::vector<EdgeCrossing> crossings(const RimEdges& first, const Eigen::Vector3d& shift_m,
                                                    double least_tilt) const;
  [[nodiscard]] bool empty() const { return edges_.empty(); }

 private:
  std::vector<RimEdge> edges_;
  BoxTree tree_;
  double longest_m_ = 0.0;
};

}  // namespace ricochet::surface
