#pragma once

#include <vector>

#include "common/fem/mesh.hpp"

namespace ricochet::fem {

struct BoundaryFace {
  Face face;
  int element = 0;
};

/// Faces that belong to one element alone, in the order of their ascending nodes; none between elements of different
/// size.
[[nodiscard]] std::vector<BoundaryFace> boundary_faces(const Mesh& mesh);

}  // namespace ricochet::fem
