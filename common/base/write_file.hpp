#pragma once

#include <string>

namespace ricochet {

/// Writes a whole file under a temporary name and renames it: readers see the old or the new one, never half of it.
/// Throws ConfigError naming the file.
void write_atomically(const std::string& path, const std::string& text);

}  // namespace ricochet
