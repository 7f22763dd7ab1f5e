#pragma once

#include <string>
#include <string_view>

namespace ricochet {

/// SHA-256 of the bytes of `text` (FIPS 180-4), 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::string_view text);

}  // namespace ricochet
