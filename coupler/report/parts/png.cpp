#include "coupler/report/parts/png.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>

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
  constexpr std::size_t before_overflow = 5552;  // so many bytes can be added up before the remainder is due
  std::uint32_t a = 1, b = 0;
  while (!bytes.empty()) {
    for (const char byte : bytes.substr(0, before_overflow)) {
      a += static_cast<unsigned char>(byte);
      b += a;
    }
    a %= 65521U;
    b %= 65521U;
    bytes.remove_prefix(std::min(before_overflow, bytes.size()));
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

/// Bits of a deflate stream, from the lowest of each byte on.
class BitWriter {
 public:
  void add(std::uint32_t bits, unsigned count) {
    waiting_ |= static_cast<std::uint64_t>(bits) << used_;
    for (used_ += count; used_ >= 8; used_ -= 8) {
      bytes_ += static_cast<char>(waiting_ & 0xffU);
      waiting_ >>= 8U;
    }
  }
  /// A code, whose highest bit comes first.
  void add_code(std::uint32_t code, unsigned count) {
    std::uint32_t reversed = 0;
    for (unsigned i = 0; i < count; ++i) reversed |= (code >> i & 1U) << (count - 1 - i);
    add(reversed, count);
  }
  [[nodiscard]] std::string bytes() && {
    if (used_ > 0) add(0, 8 - used_);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
  std::uint64_t waiting_ = 0;
  unsigned used_ = 0;  ///< bits that wait for the others of their byte
};

/// Literals, the end and lengths by the fixed codes (RFC 1951, 3.2.6).
void add_symbol(BitWriter& bits, std::uint32_t symbol) {
  if (symbol < 144) {
    bits.add_code(0x30 + symbol, 8);
  } else if (symbol < 256) {
    bits.add_code(0x190 + symbol - 144, 9);
  } else if (symbol < 280) {
    bits.add_code(symbol - 256, 7);
  } else {
    bits.add_code(0xc0 + symbol - 280, 8);
  }
}

/// A number as a symbol and further bits. Symbols stand for ever longer stretches of numbers from `offset` on:
/// 2^`finest` of one number each, then as many of two, of four and so on for every half of that (RFC 1951, 3.2.5).
struct Stretch {
  std::uint32_t symbol, rest;
  unsigned bits;
};
Stretch stretch_of(std::uint32_t number, std::uint32_t offset, unsigned finest) {
  const std::uint32_t from_zero = number - offset;
  unsigned bits = 0;
  while (from_zero >> bits >= 2U << finest) ++bits;
  return {(bits << finest) + (from_zero >> bits), from_zero & ((1U << bits) - 1U), bits};
}

void add_repeat(BitWriter& bits, std::size_t length, std::size_t distance) {
  if (length == 258) {
    add_symbol(bits, 285);
  } else {
    const auto part = stretch_of(static_cast<std::uint32_t>(length), 3, 2);
    add_symbol(bits, 257 + part.symbol);
    bits.add(part.rest, part.bits);
  }
  const auto part = stretch_of(static_cast<std::uint32_t>(distance), 1, 1);
  bits.add_code(part.symbol, 5);
  bits.add(part.rest, part.bits);
}

/// A zlib stream (RFC 1950) of one block that repeats what stood one byte or one line before, as pictures of few
/// colours mostly do.
std::string compressed(const std::string& data, std::size_t line) {
  constexpr std::size_t least = 4, most = 258, farthest = 32768;
  BitWriter bits;
  bits.add(1, 1);  // the last block
  bits.add(1, 2);  // fixed codes
  const auto repeated = [&](std::size_t at, std::size_t distance) {
    if (distance > at || distance > farthest) return std::size_t{0};
    const char* const begin = data.data() + at;
    const char* const end = begin + std::min(most, data.size() - at);
    return static_cast<std::size_t>(std::mismatch(begin, end, begin - distance).first - begin);
  };
  for (std::size_t at = 0; at < data.size();) {
    const std::size_t above = repeated(at, line), before = above < most ? repeated(at, 1) : 0;
    if (std::max(before, above) < least) {
      add_symbol(bits, static_cast<unsigned char>(data[at++]));
      continue;
    }
    add_repeat(bits, std::max(before, above), before >= above ? 1 : line);
    at += std::max(before, above);
  }
  add_symbol(bits, 256);
  std::string bytes = "\x78\x01" + std::move(bits).bytes();
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
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("PLTE", colours) +
         chunk("IDAT", compressed(lines, width + 1)) + chunk("IEND", "");
}

}  // namespace ricochet::report
