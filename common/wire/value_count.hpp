#pragma once

#include <cstddef>
#include <string_view>

namespace ricochet::wire {

/// All values of a message together. Texts and arrays of numbers count as one.
inline constexpr std::size_t most_values = std::size_t{1} << 17;

/// Whether msgpack bytes hold more values than that, before they are unpacked, which takes 24 bytes for each. Bytes
/// that are none of msgpack or break off are refused, with better words, when they are unpacked.
[[nodiscard]] bool has_too_many_values(std::string_view bytes);

}  // namespace ricochet::wire
