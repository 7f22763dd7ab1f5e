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

/// Larger arrays are not copied; for anything smaller the copy costs less than the bookkeeping.
constexpr std::size_t largest_small = 1024;

template <class Stream>
using Packer = msgpack::packer<Stream>;

template <class Stream>
void pack(Packer<Stream>& packer, std::string_view text) {
  packer.pack_str(static_cast<std::uint32_t>(text.size()));
  packer.pack_str_body(text.data(), static_cast<std::uint32_t>(text.size()));
}

template <class Stream>
void pack(Packer<Stream>& packer, const std::string& text) {
  pack(packer, std::string_view(text));
}
template <class Stream>
void pack(Packer<Stream>& packer, Kind value) {
  pack(packer, name(value));
}
template <class Stream>
void pack(Packer<Stream>& packer, std::int64_t value) {
  packer.pack_int64(value);
}

/// As a 64-bit float whatever its value: msgpack-c would write whole numbers as integers, which loses the sign of -0,
/// and is undefined for 2^64.
template <class Stream>
void pack(Packer<Stream>& packer, double value) {
  std::array<char, 1 + sizeof value> bytes{static_cast<char>(0xcb)};
  const auto bits = std::bit_cast<std::array<char, sizeof value>>(value);
  std::reverse_copy(bits.begin(), bits.end(), bytes.begin() + 1);  // big-endian
  packer.pack_bin_body(bytes.data(), bytes.size());                // these bytes, as they are
}

template <class Stream>
void pack(Packer<Stream>& packer, bool value) {
  if (value) {
    packer.pack_true();
  } else {
    packer.pack_false();
  }
}

template <class Stream>
void pack(Packer<Stream>& packer, const std::vector<std::string>& texts) {
  packer.pack_array(static_cast<std::uint32_t>(texts.size()));
  for (const auto& text : texts) pack(packer, text);
}

template <class Stream>
void pack(Packer<Stream>& packer, const Array& array) {
  const std::size_t bytes = array.data.size() * sizeof(double);
  if (bytes > max_array_bytes) {
    throw SolverError(fmt::format("an array of {} numbers is too large for one message, allowed are {}",
                                  array.data.size(), max_array_bytes / sizeof(double)));
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

template <class Stream>
void pack(Packer<Stream>& packer, const Bytes& bytes) {
  if (bytes.data.size() > max_array_bytes)
    throw SolverError(
        fmt::format("{} bytes are too many for one message, allowed are {}", bytes.data.size(), max_array_bytes));
  packer.pack_bin(static_cast<std::uint32_t>(bytes.data.size()));
  packer.pack_bin_body(bytes.data.data(), static_cast<std::uint32_t>(bytes.data.size()));
}

}  // namespace

std::optional<std::string> not_finite(double value) {
  if (std::isfinite(value)) return std::nullopt;
  return fmt::format("{}", value);
}

std::optional<std::string> not_finite(const Array& array) {
  FiniteCheck check;  // every message is looked through on both ends
  for (const double x : array.data) check.add(std::bit_cast<std::uint64_t>(x));
  if (check.all_finite()) return std::nullopt;
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

namespace {

template <class Stream>
void encode_into(Stream& stream, const Message& message) {
  stream.clear();
  Packer<Stream> packer(stream);
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

}  // namespace

void Pieces::clear() {
  small_.clear();
  large_.clear();
}

void Pieces::write(const char* bytes, std::size_t size) {
  if (size > largest_small) {
    large_.push_back({small_.size(), {bytes, size}});
  } else {
    small_.append(bytes, size);
  }
}

const std::vector<std::string_view>& Pieces::in_order() {
  in_order_.clear();
  std::string_view small = small_;
  std::size_t before = 0;
  for (const auto& large : large_) {
    in_order_.push_back(small.substr(before, large.small_before - before));
    in_order_.push_back(large.bytes);
    before = large.small_before;
  }
  in_order_.push_back(small.substr(before));
  return in_order_;
}

void encode(const Message& message, Pieces& pieces) { encode_into(pieces, message); }
void encode(const Message& message, msgpack::sbuffer& buffer) { encode_into(buffer, message); }

}  // namespace ricochet::wire
