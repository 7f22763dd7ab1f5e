#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// A curved surface of a contact at the place that touches first.
struct CurvedFacets {
  std::string surface;     ///< "body.surface"
  double edge_m = 0.0;     ///< longest edge of the facets there
  double sagitta_m = 0.0;  ///< by which the smooth surface stands off them, h^2/(8 R) of an edge
};
/// Those that the scene names, in its order; flat and rigid ones left out.
[[nodiscard]] std::vector<CurvedFacets> curved_facets(const Problem& problem, std::size_t contact);

}  // namespace ricochet::scene
