#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// A rigid plane, sphere or cylinder that stands in a body's way, as a picture shows it: of a plane a plate behind it,
/// of the others the part that faces the body. It lies where the gaps at the start have it, the initial gap included.
struct DrawnObstacle {
  std::string name;
  double strip_m = 0.0;                     ///< of a bar: the width of the plate
  std::vector<Eigen::Vector3d> place{};     ///< [m]
  std::vector<std::array<int, 4>> cells{};  ///< indices into `place`, -1 beyond the two to four of a cell
};
[[nodiscard]] std::vector<DrawnObstacle> drawn_obstacles(const Problem& problem);

}  // namespace ricochet::scene
