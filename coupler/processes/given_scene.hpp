#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "common/scene/variant.hpp"

namespace ricochet::coupler {

/// A command is given this: a scene file, and the arguments of --set, "KEY=VALUE", that change keys of it.
struct GivenScene {
  std::string path;
  std::vector<std::string> set{};

  [[nodiscard]] std::vector<scene::Override> changes() const;  ///< throws ConfigError naming the argument
  /// The problem of the changed scene, of which no file is left. Throws as load_problem; errors then name key and
  /// arguments, not lines.
  [[nodiscard]] scene::Problem load() const;
};

}  // namespace ricochet::coupler
