#include "common/wire/value_count.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace ricochet::wire {
namespace {

std::size_t big_endian(std::string_view bytes) {
  std::size_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

/// Bytes that the value at the beginning takes, without those that an array or a map holds.
std::size_t size_of_value(std::string_view bytes) {
  const auto first = static_cast<unsigned char>(bytes.front());
  if (first >= 0xa0 && first < 0xc0) return 1U + (first & 0x1fU);  // a short text
  if (first < 0xc4 || first >= 0xe0) return 1;
  const auto with_length = [&](std::size_t digits, std::size_t more) {
    return 1 + digits + more + big_endian(bytes.substr(1, digits));
  };
  switch (first) {
    case 0xc4:
    case 0xd9: return with_length(1, 0);
    case 0xc5:
    case 0xda: return with_length(2, 0);
    case 0xc6:
    case 0xdb: return with_length(4, 0);
    case 0xc7: return with_length(1, 1);
    case 0xc8: return with_length(2, 1);
    case 0xc9: return with_length(4, 1);
    default: break;
  }
  // From 0xca on: floats, integers, extensions of fixed size, then heads of arrays and maps.
  constexpr std::array<std::uint8_t, 22> sizes = {5, 9, 2, 3, 5, 9, 2, 3, 5, 9, 3, 4, 6, 10, 18, 0, 0, 0, 3, 5, 3, 5};
  return sizes[first - 0xcaU];
}

}  // namespace

bool has_too_many_values(std::string_view bytes) {
  std::size_t values = 0;
  while (!bytes.empty()) {
    if (++values > most_values) return true;
    bytes.remove_prefix(std::min(bytes.size(), size_of_value(bytes)));
  }
  return false;
}

}  // namespace ricochet::wire
