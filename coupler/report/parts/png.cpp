#include "coupler/report/parts/png.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>

namespace ricochet::report {
namespace {

void append_big_endian(std::string& bytes, std::uint32_t number) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) bytes += static_cast<char>(number >> shift & 0xffU);
}

std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
  }
  return ~crc;
}

std::uint32_t adler32(std::string_view bytes) {
  std::uint32_t a = 1, b = 0;
  for (const char byte : bytes) {
    a = (a + static_cast<unsigned char>(byte)) % 65521U;
    b = (b + a) % 65521U;
  }
  return b << 16U | a;
}

std::string chunk(const std::string& type, const std::string& data) {
  std::string bytes;
  append_big_endian(bytes, static_cast<std::uint32_t>(data.size()));
  bytes += type + data;
  append_big_endian(bytes, crc32(type + data));
  return bytes;
}

/// A zlib stream of stored blocks.
std::string stored(const std::string& data) {
  constexpr std::size_t most = 65535;
  std::string bytes = "\x78\x01";
  for (std::size_t begin = 0; begin < data.size(); begin += most) {
    const auto size = std::min(most, data.size() - begin);
    bytes += begin + size == data.size() ? '\x01' : '\x00';
    for (const std::size_t number : {size, ~size}) {
      bytes += static_cast<char>(number & 0xffU);
      bytes += static_cast<char>(number >> 8U & 0xffU);
    }
    bytes.append(data, begin, size);
  }
  append_big_endian(bytes, adler32(data));
  return bytes;
}

}  // namespace

std::string png(std::size_t width, std::size_t height, const std::vector<std::uint8_t>& pixels,
                const std::vector<Rgb>& palette) {
  const bool sizes = width >= 1 && width <= 65535 && height >= 1 && height <= 65535 && pixels.size() == width * height;
  if (!sizes || palette.empty() || palette.size() > 256) throw std::invalid_argument("png: sizes do not fit");
  std::string header, colours, lines;
  append_big_endian(header, static_cast<std::uint32_t>(width));
  append_big_endian(header, static_cast<std::uint32_t>(height));
  header += {'\x08', '\x03', '\x00', '\x00', '\x00'};  // 8 bits, palette, deflate, filters by line, not interlaced
  for (const auto& colour : palette) colours.append(colour.begin(), colour.end());
  for (std::size_t row = 0; row < height; ++row) {
    lines += '\x00';  // no filter
    const auto begin = pixels.begin() + static_cast<std::ptrdiff_t>(row * width);
    lines.append(begin, begin + static_cast<std::ptrdiff_t>(width));
  }
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("PLTE", colours) + chunk("IDAT", stored(lines)) +
         chunk("IEND", "");
}

}  // namespace ricochet::report
