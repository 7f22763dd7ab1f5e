#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "common/fem/mesh.hpp"
#include "common/surface/box_tree.hpp"
#include "common/surface/rim_edges.hpp"
#include "common/surface/surface_face.hpp"

/// Dual mortar between two surfaces of any shape and meshes (Wohlmuth 2000; Hueeber, Wohlmuth 2005; Popp 2012).
///
/// Multipliers live on the first surface, with the dual basis psi of its shape functions phi: on each of its faces,
/// over the part e of it that lies opposite the second surface,
///   psi = D M^-1 phi,   D = diag(integral_e phi),   M = integral_e phi phi^T,   so that   integral_e psi_j phi_k =
///   D_jk
/// (restricted to e, after Cichosz and Bischoff 2011: a face that hangs over the other surface's end keeps its patch
/// test). A node j of the first surface then has one row,
///   gap_j = n_j . (sum_k weight_jk x_k - x_j),   weight_jk = integral psi_j phi_k / area_j,   area_j = integral phi_j
/// with k the nodes of the second surface. Weights sum to one and, where the surfaces touch, to the place of j: forces
/// and moments are in balance. Faces opposite are found in the plane of each face of the first surface, to which
/// those of the second are projected along n, which changes from node to node, and by which they are cut (Puso, Laursen
/// 2004, who project along the face's normal: of two balls that puts places off by gap times slope, and the force by
/// 0.4 % at a radius of contact of 0.12 R).
///
/// n_j is the normal of the surface to which both deform where they touch: that of each counts by the compliance
/// (1 - nu^2)/E of the other, so that half-spaces of one material meet halfway. Along it, what bodies slide does not
/// change the gap. Bodies that turn or stand tilted may touch by an edge or a corner: there, and where the normals
/// differ by more than bodies do that touch where they are smooth, n_j is that of the smooth one; the row of an edge is
/// against what the line along n_j meets. Nodes at edges of the second surface then have rows of their own, against the
/// first, but for those that lie on a face all of whose nodes have rows. Edges of solids that cross have one, too,
/// across both.
///
/// Rows are rates; what they start from is the gap of the surfaces along n_j at the node. Between the corners of a
/// face, of shape functions N and with normals n_k, the surface is
///   X = p - 1/2 sum_k N_k (p - x_k) . n_k m,   p = sum_k N_k x_k,   m the face's normal
/// (half of Phong tessellation, Boubekeur and Alexa 2008): exact for a paraboloid through the corners with those
/// normals, so that it leaves of a circle's sagitta h^2/(8R) no more than h^4/(128 R^3). Where the node lies opposite
/// nothing, the gap is the mean with phi_j over what of its faces does.
namespace ricochet::surface {

using fem::WeightedNode;

struct MortarRow {
  int node = -1;  ///< of the first surface; of several the one with the largest share
  double area_m2 = 0.0;
  std::vector<WeightedNode> opposite;     ///< ascending by node
  int patch = 0;                          ///< a node between two smooth pieces of a surface has a row for each
  Eigen::Vector3d normal{0.0, 0.0, 0.0};  ///< n_j
  double gap_m = 0.0;                     ///< of the surfaces
  std::vector<WeightedNode> own{};        ///< of the first surface, where it is not `node` alone: ascending by node
  /// Weights >= 0 of the same nodes, integral phi_j phi_k / area_j, where they are asked for.
  std::vector<WeightedNode> overlap{};
};

/// The second surface, so that what lies opposite a face need not be looked for among all of it.
class OppositeFaces {
 public:
  /// `period_m`: > 0 where a coordinate repeats.
  OppositeFaces(std::vector<SurfaceFace> faces, const Eigen::Vector2d& period_m);

  /// Rows of the nodes that lie opposite this surface when it has moved by `shift_m` against the first, ascending by
  /// piece and node. `first_share`: what the normal of the first counts.
  /// `edges_touch`: bodies turn or stand tilted. A node where smooth pieces of the first surface meet then has one row.
  [[nodiscard]] std::vector<MortarRow> rows(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                                            double first_share = 0.5, bool edges_touch = false) const;
  /// Rows of nodes that are to stay on this surface where it is, with MortarRow::overlap.
  [[nodiscard]] std::vector<MortarRow> rows_of_tie(const std::vector<SurfaceFace>& first) const;
  /// No more than the distance from the first surface, and by about an edge of that less [m].
  [[nodiscard]] double apart_m(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m) const;
  [[nodiscard]] const std::vector<SurfaceFace>& faces() const { return faces_; }
  /// Whether smooth pieces of it meet at edges.
  [[nodiscard]] bool has_edges() const { return !edges_.empty(); }

 private:
  struct Image {
    std::size_t face;
    Eigen::Vector3d moved_m;  ///< where the surface repeats
  };
  class RowSums;
  using Normals = std::function<std::array<Eigen::Vector3d, 4>(const SurfaceFace&)>;
  /// Integrals over the pieces of the first surface's faces that lie opposite along these normals of its
  /// nodes.
  [[nodiscard]] RowSums sums(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                             const Normals& normals_of, bool edges_touch, bool overlaps = false) const;
  /// Adds the rows of edges that cross, of solids.
  void add_crossing_rows(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                         std::vector<MortarRow>& rows) const;
  /// Adds the rows of nodes at edges of this surface.
  void add_edge_rows(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                     std::vector<MortarRow>& rows) const;
  [[nodiscard]] Eigen::Vector3d within_period(Eigen::Vector3d shift_m) const;
  /// A node at an edge of the surface.
  struct EdgeNode {
    int node;
    Eigen::Vector3d x;
    double area_m2 = 0.0;
    double thickness_m = 0.0;              ///< largest of its faces
    std::vector<Eigen::Vector3d> normals;  ///< of its faces
  };
  void find_edges();
  std::vector<SurfaceFace> faces_;
  std::vector<EdgeNode> edges_;
  BoxTree edge_tree_;  ///< of their places
  RimEdges rim_edges_;
  Eigen::Vector2d period_m_;
  std::vector<Image> images_;
  BoxTree tree_;
};

/// Two surfaces that may touch, of which rows are written for any place of the second.
struct ContactMesh {
  std::vector<SurfaceFace> first;
  OppositeFaces second;
  double edge_m = 0.0;       ///< shortest of the first
  double first_share = 0.5;  ///< of the normals
  bool edges_touch = false;  ///< see OppositeFaces::rows

  [[nodiscard]] std::vector<MortarRow> rows(const Eigen::Vector3d& shift_m) const {
    return second.rows(first, shift_m, first_share, edges_touch);
  }
};

/// Where the second surface touches the first: its shift, moved on along the normal n of the place that then touches.
struct Touch {
  Eigen::Vector3d shift_m, normal;
  double gap_m;  ///< there, before it was moved
};
/// From `shift_m`; none where nothing lies opposite. `along`: the one direction to move it in, none: zero.
[[nodiscard]] std::optional<Touch> touching(const ContactMesh& mesh, const Eigen::Vector3d& shift_m,
                                            const Eigen::Vector3d& along);

}  // namespace ricochet::surface
