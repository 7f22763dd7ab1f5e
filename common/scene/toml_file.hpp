#pragma once

#include <string>
#include <toml.hpp>

namespace ricochet::scene {

/// The bytes of a file. Throws ConfigError if it cannot be read.
[[nodiscard]] std::string read_text(const std::string& path);
/// False, too, for a name that no file can have, or in a folder that may not be looked into.
[[nodiscard]] bool is_file(const std::string& path);

/// The text of a scene or study file as TOML 1.0; `path` is for messages. Throws ConfigError naming file and line, also
/// for what `check_text` refuses. The only place that instantiates the parser: it takes the compiler ten seconds.
[[nodiscard]] toml::value parse_toml(const std::string& path, const std::string& text);

}  // namespace ricochet::scene
