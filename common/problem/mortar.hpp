#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <vector>

#include "common/fem/element_kind.hpp"

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
/// and moments are in balance. The opposite faces are found in the plane of each face of the first surface, to which
/// those of the second are projected and by which they are cut (Puso, Laursen 2004).
namespace ricochet::scene {

/// A face of a surface in its place: an edge, a triangle or a quadrilateral.
struct SurfaceFace {
  fem::Face node;
  std::array<Eigen::Vector3d, 4> x;  ///< of its nodes [m]
  std::array<double, 4> measure{};   ///< at them: area per length of an edge [m], thickness or circumference; else 1
  Eigen::Vector3d normal;            ///< out of the body
};

/// A node with its share in a row.
struct WeightedNode {
  int node = -1;
  double weight = 0.0;
};

struct MortarRow {
  int node = -1;  ///< of the first surface
  double area_m2 = 0.0;
  std::vector<WeightedNode> opposite;  ///< ascending by node
};

/// The second surface, so that what lies opposite a face need not be looked for among all of it.
class OppositeFaces {
 public:
  /// `along`: a direction in which flat surfaces are searched; none: curved. `period_m`: > 0 where a coordinate
  /// repeats.
  OppositeFaces(std::vector<SurfaceFace> faces, const std::optional<Eigen::Vector3d>& along,
                const Eigen::Vector2d& period_m);

  /// Rows of the nodes that lie opposite this surface when it has moved by `shift_m` against the first, ascending.
  [[nodiscard]] std::vector<MortarRow> rows(const std::vector<SurfaceFace>& first, Eigen::Vector3d shift_m) const;
  [[nodiscard]] const std::vector<SurfaceFace>& faces() const { return faces_; }

 private:
  struct Image {
    std::size_t face;
    Eigen::Vector3d moved_m;  ///< where the surface repeats
    double low_m;             ///< along the direction
  };
  std::vector<SurfaceFace> faces_;
  std::optional<Eigen::Vector3d> along_;
  std::vector<Image> images_;  ///< ascending by low_m
  double longest_m_ = 0.0;
  Eigen::Vector2d period_m_;
};

/// Two surfaces that may touch, of which rows are written for any place of the second.
struct ContactMesh {
  std::vector<SurfaceFace> first;
  OppositeFaces second;
  std::map<int, Eigen::Vector3d> normal;  ///< at the nodes of the first
};

}  // namespace ricochet::scene
