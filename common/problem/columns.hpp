#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace ricochet::scene {

/// Whether places lie within a closed surface of triangles: what is above them is crossed an odd number of times. The
/// triangles are sorted by the cells of a grid across z that they lie over, so a place takes few of them.
class Columns {
 public:
  using Triangles = std::vector<std::array<int, 3>>;

  /// Triangles of places `x`, whose box is `low` to `high`; both must outlive it. `shortest_m`: an edge.
  Columns(const Triangles& triangles, const std::vector<Eigen::Vector3d>& x, const Eigen::Vector3d& low,
          const Eigen::Vector3d& high, double shortest_m);

  [[nodiscard]] bool within(const Eigen::Vector3d& place) const;

 private:
  [[nodiscard]] int cell(const Eigen::Vector3d& place, int axis) const;

  const Triangles& triangles_;
  const std::vector<Eigen::Vector3d>& x_;
  Eigen::Vector3d low_;
  double aside_m_;
  int cells_;  ///< along each side of the grid
  Eigen::Vector2d per_m_;
  std::vector<std::vector<int>> over_;  ///< per cell
};

}  // namespace ricochet::scene
