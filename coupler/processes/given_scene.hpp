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
  void add(const std::vector<scene::Override>& changes);       ///< as arguments behind the others
  /// The problem of the changed scene, of which no file is left. Throws as load_problem; errors then name key and
  /// arguments, not lines.
  [[nodiscard]] scene::Problem load() const;
};

/// Where a command keeps the scene that it has changed, by the name of the user's: "scene/NAME.toml" in its results.
[[nodiscard]] std::string changed_scene_name(const std::string& scene_path);
/// Writes it there and returns its path. Throws as write_variant.
[[nodiscard]] std::string write_changed_scene(const std::string& scene_path,
                                              const std::vector<scene::Override>& changes, const std::string& results);

}  // namespace ricochet::coupler
