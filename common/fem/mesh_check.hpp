#pragma once

#include <optional>
#include <string>

#include "common/fem/mesh.hpp"

namespace ricochet::fem {

/// Tells why an element is unusable, and where ("is inverted or not convex at (r, z) = ..."); nothing if it is fine.
[[nodiscard]] std::optional<std::string> element_defect(const Mesh& mesh, int element);

}  // namespace ricochet::fem
