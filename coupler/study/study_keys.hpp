#pragma once

#include <string>
#include <vector>

#include "common/scene/reader.hpp"
#include "common/scene/variant.hpp"

/// Tables of a study file whose keys are those of a scene.
namespace ricochet::coupler {

/// A value in such a table: its whole key in the scene, and where it stands.
struct Leaf {
  std::string key;
  const scene::Toml* value;
};

/// The values of a table, in the file's order. Refuses keys that no scene has; `at` is the table's name in errors.
[[nodiscard]] std::vector<Leaf> leaves_of(const scene::TableReader& reader, const scene::Toml& table,
                                          const std::string& at);

/// A number, a text or a list of numbers.
[[nodiscard]] scene::Override override_of(const scene::TableReader& reader, const std::string& at,
                                          const std::string& key, const scene::Toml& value);

/// The table `key` of `reader`, key by key, the protocol not among them; empty if there is none.
[[nodiscard]] std::vector<scene::Override> load_changes(scene::TableReader& reader, const std::string& key);

}  // namespace ricochet::coupler
