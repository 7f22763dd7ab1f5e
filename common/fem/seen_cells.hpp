#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "common/fem/mesh.hpp"

namespace ricochet::fem {

/// A picture of a mesh shows its elements, and of a solid the faces that belong to one element alone. A node, and its
/// image across the period where a cell reaches it there, are two nodes of the picture.
struct SeenCells {
  /// More are not drawn.
  static constexpr std::size_t most = 100000;

  std::vector<int> node;    ///< of the mesh
  std::vector<bool> image;  ///< per node: across the period
  std::vector<Eigen::Vector3d> position_m;
  std::vector<std::array<int, 4>> cells;  ///< indices into `node`, -1 beyond the two to four of a cell
  std::vector<int> element;               ///< per cell
};
[[nodiscard]] SeenCells seen_cells(const Mesh& mesh);

}  // namespace ricochet::fem
