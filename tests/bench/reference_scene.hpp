#pragma once

#include <string>

namespace ricochet::bench {

/// The reference scene, configs/kim_impact.toml (0.5 mm), refined and shortened.
struct SceneChoice {
  int refinement = 1;  ///< elements per element of the 0.5 mm mesh and direction; the step shrinks with them
  std::string protocol = "hughes_liu";
  int substeps = 1;  ///< the window is `substeps` steps long
  long steps = 300;  ///< steps of the explicit side: `steps / substeps` windows
  std::string transport = "auto";
  int carbide_lengths = 1;   ///< length of the carbide cylinder over that of the scene
  bool every_step = false;   ///< history of every window, not of the first and the last only
  std::string participants;  ///< [[participant]] tables, as text; empty: the shipped ones
};

/// Two explicit participants, one per body, beside the implicit one.
[[nodiscard]] std::string two_explicit_participants();

/// Writes the scene to `path`: no fields, history at the start and the end only (unless `every_step`), no end before
/// the last window. Returns `path`.
std::string write_reference_scene(const SceneChoice& choice, const std::string& path);

/// "0.5 mm", "0.25 mm", ...
[[nodiscard]] std::string mesh_name(int refinement);

}  // namespace ricochet::bench
