#pragma once

#include <string>

namespace ricochet::scene {

/// Largest scene or study file [bytes], deepest nesting of brackets, longest dotted key and most digits after 0b: more
/// makes the TOML parser run out of stack, memory, patience or its integers.
inline constexpr std::size_t most_bytes = std::size_t{1} << 20;
inline constexpr int deepest_nesting = 32, most_key_parts = 32, most_binary_digits = 62;

/// Before it is parsed. Throws ConfigError naming file, line, what was found and the limit, also for a text that is no
/// UTF-8.
void check_text(const std::string& path, const std::string& text);

}  // namespace ricochet::scene
