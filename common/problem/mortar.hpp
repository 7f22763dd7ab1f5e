#pragma once

#include <array>
#include <vector>

/// Dual mortar between two flat surfaces whose meshes do not match (Wohlmuth 2000; Hueeber, Wohlmuth 2005; Popp 2012).
///
/// Multipliers live on the first surface, with the dual basis psi of its shape functions phi: on each of its edges,
/// over the part e of it that lies opposite the second surface,
///   psi = D M^-1 phi,   D = diag(integral_e phi),   M = integral_e phi phi^T,   so that   integral_e psi_j phi_k =
///   D_jk
/// (restricted to e, after Cichosz and Bischoff 2011: an edge that hangs over the other surface's end keeps its patch
/// test). A node j of the first surface then has one row,
///   gap_j = g0 + n . (sum_k weight_jk u_k - u_j),   weight_jk = integral psi_j phi_k / area_j,   area_j = integral
///   phi_j
/// with k the nodes of the second surface. Weights sum to one, and to the place of j: forces and moments are in
/// balance.
namespace ricochet::scene {

/// An edge of a surface; `along_m` its ends on the line that the surfaces lie on, ascending.
struct SurfaceEdge {
  std::array<int, 2> node;
  std::array<double, 2> along_m;
  std::array<double, 2> measure;  ///< at its ends: area per length [m], thickness or circumference
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

/// Rows of the nodes that lie opposite the second surface, ascending by node. `period_m` > 0: the line repeats so.
[[nodiscard]] std::vector<MortarRow> mortar_rows(const std::vector<SurfaceEdge>& first,
                                                 const std::vector<SurfaceEdge>& second, double period_m);

}  // namespace ricochet::scene
