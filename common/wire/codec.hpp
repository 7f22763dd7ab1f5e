#pragma once

#include <cstddef>
#include <cstdint>
#include <msgpack.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/wire/message.hpp"

namespace ricochet::wire {

/// Largest array that fits one message, and the largest message: nonsense must not be able to ask for more memory.
inline constexpr std::size_t max_array_bytes = std::size_t{1} << 30;
inline constexpr std::size_t max_message_bytes = 2 * max_array_bytes;

/// A message in bytes, in the pieces in which they lie in memory. A large array is not copied: it stays in the message,
/// which therefore must stay as it is as long as the pieces are used.
class Pieces {
 public:
  /// In the order in which they travel; valid until the next `clear` or `write`.
  [[nodiscard]] const std::vector<std::string_view>& in_order();
  void clear();
  /// Adds bytes; for msgpack.
  void write(const char* bytes, std::size_t size);

 private:
  struct Large {
    std::size_t small_before;  ///< so many bytes of `small_` come before it, with all that is large among them
    std::string_view bytes;
  };
  std::string small_;
  std::vector<Large> large_;
  std::vector<std::string_view> in_order_;
};

/// Encodes header and body as one msgpack map with field names; replaces what `pieces` or `buffer` hold. Whether the
/// numbers are finite is for the caller to ask (`require_finite`).
void encode(const Message& message, Pieces& pieces);
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

/// Finds out in a loop over numbers whether all are finite: a few operations on integers for each, so that the compiler
/// makes vectors of them.
class FiniteCheck {
 public:
  /// `bits`: of a double.
  void add(std::uint64_t bits) { carry_ |= (bits & exponent) + lowest_of_exponent; }
  [[nodiscard]] bool all_finite() const { return carry_ >> 63 == 0; }

 private:
  static constexpr std::uint64_t exponent = 0x7ff0'0000'0000'0000, lowest_of_exponent = 0x0010'0000'0000'0000;
  std::uint64_t carry_ = 0;  ///< an exponent of ones only, inf or nan, carries into the highest bit
};

/// Strict decoding into `message` (whose vectors keep their capacity). Throws ProtocolError that names the kind and the
/// field for: not a map, unknown, missing, duplicate, wrong-typed or wrong-length fields, shape and data that disagree,
/// non-finite numbers, another protocol version (says both), bytes left over. `sender` is named in the text.
void decode(std::string_view bytes, std::string_view sender, Message& message);

}  // namespace ricochet::wire
