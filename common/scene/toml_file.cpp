#include "common/scene/toml_file.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "common/base/error.hpp"
#include "common/scene/check_text.hpp"

namespace ricochet::scene {

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw ConfigError(path + ": cannot be read");
  return text.str();
}

bool is_file(const std::string& path) {
  std::error_code no_status;
  return std::filesystem::is_regular_file(path, no_status);
}

Toml parse_toml(const std::string& path, const std::string& text) {
  check_text(path, text);
  std::istringstream stream(text);
  try {
    return toml::parse<toml::discard_comments, std::map, TomlArray>(stream, path);
  } catch (const std::exception& error) {  // toml11 throws several kinds, each with the underlined source
    throw ConfigError(fmt::format("{}: not a TOML file; allowed: TOML 1.0\n{}", path, error.what()));
  }
}

}  // namespace ricochet::scene
