#pragma once

#include <string>

namespace ricochet::coupler {

/// `ricochet init`: writes a commented starter scene `<name>.toml` (the ".toml" may be given). Returns the path.
/// Throws ConfigError if the file exists or cannot be written.
std::string write_starter_scene(const std::string& name);

}  // namespace ricochet::coupler
