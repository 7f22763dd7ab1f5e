#pragma once

#include <vector>

#include "common/fem/seen_cells.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// A body as a picture of the scene shows it before the run.
struct DrawnBody {
  fem::SeenCells seen;
  std::vector<int> owner;  ///< per cell: index into Scene::participants of who integrates its element
};
[[nodiscard]] std::vector<DrawnBody> drawn_bodies(const Problem& problem);

/// Nodes that something holds for; each mark once, also where it has none.
struct DrawnMark {
  enum class Kind { contact, support, load, prescribed, absorbing, joint, interface, probe };
  Kind kind = Kind::contact;
  std::string contact;  ///< name of one of several
  std::vector<Eigen::Vector3d> places_m;
};
[[nodiscard]] std::vector<DrawnMark> drawn_marks(const Problem& problem);

}  // namespace ricochet::scene
