#include "common/base/base64.hpp"

#include <array>
#include <cstdint>

namespace ricochet {
namespace {

constexpr std::string_view digits_of_base64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::string base64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  std::size_t out = 0;
  const auto write = [&](std::uint32_t group, std::size_t digits) {
    for (std::size_t k = 0; k < digits; ++k) text[out++] = digits_of_base64[group >> (18 - 6 * k) & 63U];
  };
  const auto byte = [&](std::size_t i) -> std::uint32_t { return static_cast<unsigned char>(bytes[i]); };
  const std::size_t whole = bytes.size() / 3 * 3, rest = bytes.size() - whole;
  for (std::size_t i = 0; i < whole; i += 3) write(byte(i) << 16U | byte(i + 1) << 8U | byte(i + 2), 4);
  if (rest > 0) write(byte(whole) << 16U | (rest > 1 ? byte(whole + 1) << 8U : 0U), rest + 1);
  return text;
}

std::optional<std::string> from_base64(std::string_view text) {
  if (text.size() % 4 != 0) return std::nullopt;
  std::array<int, 256> value{};
  value.fill(-1);
  for (std::size_t i = 0; i < digits_of_base64.size(); ++i)
    value[static_cast<unsigned char>(digits_of_base64[i])] = static_cast<int>(i);
  std::size_t padding = 0;
  while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') ++padding;
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t group = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int digit = i + padding < text.size() ? value[static_cast<unsigned char>(text[i])] : 0;
    if (digit < 0) return std::nullopt;
    group = group << 6 | static_cast<std::uint32_t>(digit);
    if (i % 4 != 3) continue;
    for (const unsigned shift : {16U, 8U, 0U}) bytes += static_cast<char>(group >> shift & 255U);
  }
  bytes.resize(bytes.size() - padding);
  return bytes;
}

}  // namespace ricochet
