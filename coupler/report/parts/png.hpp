#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ricochet::report {

using Rgb = std::array<std::uint8_t, 3>;

/// A picture of width x height pixels (1 to 65535 each; std::invalid_argument otherwise), row by row from the top, each
/// an index into `palette` (1 to 256 colours): the bytes of a PNG file (RFC 2083), compressed where pixels repeat
/// the one before or the line above.
[[nodiscard]] std::string png(std::size_t width, std::size_t height, const std::vector<std::uint8_t>& pixels,
                              const std::vector<Rgb>& palette);

}  // namespace ricochet::report
