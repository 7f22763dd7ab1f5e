#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ricochet {

/// RFC 4648, with padding, in one line.
[[nodiscard]] std::string base64(std::string_view bytes);

/// The bytes of such a text; none if it is none.
[[nodiscard]] std::optional<std::string> from_base64(std::string_view text);

}  // namespace ricochet
