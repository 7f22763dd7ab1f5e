#pragma once

#include <string>

namespace ricochet::bench {

/// Two equal bodies that meet on a wide face, stepped by all_explicit: thin along the impact, so that a wave has soon
/// reached all of them, and `elements` wide, which grows with the ranks.
struct RankScene {
  bool solid = false;  ///< hexahedra, a square face; else quadrilaterals in plane strain
  int elements = 640;  ///< across
  int deep = 40;       ///< along the impact, of each body
  long steps = 200;
  int ranks = 1;  ///< 1: the participant has no ranks
};

std::string write_rank_scene(const RankScene& choice, const std::string& path);

}  // namespace ricochet::bench
