#pragma once

#include <string>
#include <variant>
#include <vector>

namespace ricochet::scene {

/// A key of a scene file set to another value. Bodies and participants go by their names: "time.step_s",
/// "body.steel.material.youngs_modulus_pa", "body.steel.mesh.elements" (a list in two dimensions),
/// "partition.implicit_length_m.steel", "coupling.protocol".
struct Override {
  std::string key;
  std::variant<double, std::string, std::vector<double>, bool, std::vector<std::string>> value;
};

/// "KEY=VALUE" as a command line has it: a value as in a scene file, and a text needs no quotes. Throws ConfigError.
[[nodiscard]] Override parse_override(const std::string& argument);
/// The other way round; a text gets no quotes. The numbers that are read again have the same bits.
[[nodiscard]] std::string to_argument(const Override& change);

/// Writes the scene file with some keys changed, to be loaded like any other: tables that are missing are added, paths
/// in it and in the changes count from its folder, a step takes the place of a safety factor or of a largest step.
/// Throws ConfigError if the file cannot be read or written, or a key leads through something that is no table; keys
/// that no scene has are refused when it is loaded.
void write_variant(const std::string& scene_path, const std::vector<Override>& overrides, const std::string& out_path);

}  // namespace ricochet::scene
