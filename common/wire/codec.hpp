#pragma once

#include <cstddef>
#include <msgpack.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "common/wire/message.hpp"

namespace ricochet::wire {

/// Largest array that fits one message, and the largest message: nonsense must not be able to ask for more memory.
inline constexpr std::size_t max_array_bytes = std::size_t{1} << 30;
inline constexpr std::size_t max_message_bytes = 2 * max_array_bytes;

/// Encodes header and body as one msgpack map with field names; replaces what `buffer` holds.
/// Throws what `require_finite` throws.
void encode(const Message& message, msgpack::sbuffer& buffer);

/// Throws SolverError that names the field (row and column, too) if a number of the message is not finite.
void require_finite(const Message& message);

/// "nan at row 3, column 1" for the first number that is not finite; nothing if all are.
[[nodiscard]] std::optional<std::string> not_finite(double value);
[[nodiscard]] std::optional<std::string> not_finite(const Array& array);
template <class NotANumber>
[[nodiscard]] std::optional<std::string> not_finite(const NotANumber&) {
  return std::nullopt;
}

/// Strict decoding into `message` (whose vectors keep their capacity). Throws ProtocolError that names the kind and the
/// field for: not a map, unknown, missing, duplicate, wrong-typed or wrong-length fields, shape and data that disagree,
/// non-finite numbers, another protocol version (says both), bytes left over. `sender` is named in the text.
void decode(std::string_view bytes, std::string_view sender, Message& message);

}  // namespace ricochet::wire
