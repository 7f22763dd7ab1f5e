#pragma once

#include <string>
#include <vector>

#include "common/fem/model.hpp"

namespace ricochet::scene {

/// A common material, which a body takes by its name alone. Handbooks differ by some per cent, and so do batches.
struct LibraryMaterial {
  std::string name;
  fem::Material material;
  std::string source;
};

/// In the order of docs/scene.md, whose table a test compares with this one.
[[nodiscard]] const std::vector<LibraryMaterial>& material_library();

}  // namespace ricochet::scene
