#pragma once

#include <map>
#include <string>
#include <vector>

namespace ricochet::scene {

/// Every table of a kind of file and the keys it may hold.
using Schema = std::map<std::string, std::vector<std::string>>;

/// That of a scene file: the one list that the reader enforces and that docs/scene.md is tested against.
/// `partition.implicit_length_m` and `partition.implicit_groups` hold body names instead.
[[nodiscard]] const Schema& scene_schema();

}  // namespace ricochet::scene
