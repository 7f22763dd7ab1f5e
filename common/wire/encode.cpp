#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"

namespace ricochet::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "array data travel as they lie in memory");

using Packer = msgpack::packer<msgpack::sbuffer>;

void pack(Packer& packer, std::string_view text) {
  packer.pack_str(static_cast<std::uint32_t>(text.size()));
  packer.pack_str_body(text.data(), static_cast<std::uint32_t>(text.size()));
}

void pack(Packer& packer, const std::string& text) { pack(packer, std::string_view(text)); }
void pack(Packer& packer, Kind value) { pack(packer, name(value)); }
void pack(Packer& packer, std::int64_t value) { packer.pack_int64(value); }

/// As a 64-bit float whatever its value: msgpack-c would write whole numbers as integers, which loses the sign of -0,
/// and is undefined for 2^64.
void pack(Packer& packer, double value) {
  std::array<char, 1 + sizeof value> bytes{static_cast<char>(0xcb)};
  const auto bits = std::bit_cast<std::array<char, sizeof value>>(value);
  std::reverse_copy(bits.begin(), bits.end(), bytes.begin() + 1);  // big-endian
  packer.pack_bin_body(bytes.data(), bytes.size());                // these bytes, as they are
}

void pack(Packer& packer, bool value) {
  if (value) {
    packer.pack_true();
  } else {
    packer.pack_false();
  }
}

void pack(Packer& packer, const std::vector<std::string>& texts) {
  packer.pack_array(static_cast<std::uint32_t>(texts.size()));
  for (const auto& text : texts) pack(packer, text);
}

void pack(Packer& packer, const Array& array) {
  const std::size_t bytes = array.data.size() * sizeof(double);
  if (bytes > max_array_bytes) {
    throw SolverError(fmt::format("an array of {} numbers is too large for one message", array.data.size()));
  }
  packer.pack_map(2);
  pack(packer, std::string_view("shape"));
  packer.pack_array(2);
  packer.pack_int64(array.rows);
  packer.pack_int64(array.columns);
  pack(packer, std::string_view("data"));
  packer.pack_bin(static_cast<std::uint32_t>(bytes));
  packer.pack_bin_body(reinterpret_cast<const char*>(array.data.data()), static_cast<std::uint32_t>(bytes));
}

void pack(Packer& packer, const Bytes& bytes) {
  if (bytes.data.size() > max_array_bytes)
    throw SolverError(fmt::format("{} bytes are too many for one message", bytes.data.size()));
  packer.pack_bin(static_cast<std::uint32_t>(bytes.data.size()));
  packer.pack_bin_body(bytes.data.data(), static_cast<std::uint32_t>(bytes.data.size()));
}

}  // namespace

std::optional<std::string> not_finite(double value) {
  if (std::isfinite(value)) return std::nullopt;
  return fmt::format("{}", value);
}

std::optional<std::string> not_finite(const Array& array) {
  // Every message is looked through on both ends. Exponents of ones only: inf or nan; as integers the loop is
  // vectorised.
  constexpr std::uint64_t exponent = 0x7ff0'0000'0000'0000;
  std::uint64_t any = 0;
  for (const double x : array.data)
    any |= static_cast<std::uint64_t>((std::bit_cast<std::uint64_t>(x) & exponent) == exponent);
  if (any == 0) return std::nullopt;
  const auto found = std::find_if(array.data.begin(), array.data.end(), [](double x) { return !std::isfinite(x); });
  const auto index = found - array.data.begin();
  const auto columns = std::max(array.columns, 1);
  return fmt::format("{} at row {}, column {}", *found, index / columns, index % columns);
}

void require_finite(const Message& message) {
  for (const auto& field : fields_of(message.kind)) {
    const auto found = std::visit([](const auto* value) { return not_finite(*value); }, field.of(message));
    if (!found) continue;
    throw SolverError(fmt::format("'{}' of '{}' is not finite: {}", field.name, name(message.kind), *found));
  }
}

void encode(const Message& message, msgpack::sbuffer& buffer) {
  require_finite(message);
  buffer.clear();
  Packer packer(buffer);
  const auto& header = header_fields();
  const auto& fields = fields_of(message.kind);
  packer.pack_map(static_cast<std::uint32_t>(header.size() + fields.size()));
  for (const auto* list : {&header, &fields}) {
    for (const auto& field : *list) {
      pack(packer, field.name);
      std::visit([&](const auto* value) { pack(packer, *value); }, field.of(message));
    }
  }
}

}  // namespace ricochet::wire
