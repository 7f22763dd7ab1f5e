#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/value_count.hpp"

namespace ricochet::wire {
namespace {

using Object = msgpack::object;

/// A message has five to twenty fields and texts by the dozen. The limits keep a few wrong bytes from asking for
/// gigabytes.
const msgpack::unpack_limit limits(/*array*/ 1U << 16, /*map*/ 256, /*str*/ 1U << 24, /*bin*/ max_array_bytes,
                                   /*ext*/ 0,
                                   /*depth*/ 4);

/// The first that is larger than these, with the limit; empty: something else is wrong.
std::string size_beyond_limit(const msgpack::unpack_error& error) {
  const auto is = [&error](auto* kind) { return dynamic_cast<decltype(kind)>(&error) != nullptr; };
  const auto text = [](std::string_view what, std::size_t most, std::string_view unit) {
    return fmt::format("a message with {} beyond the limit, allowed are {} {}", what, most, unit);
  };
  using namespace msgpack;
  if (is(static_cast<const array_size_overflow*>(nullptr))) return text("an array", limits.array(), "values");
  if (is(static_cast<const map_size_overflow*>(nullptr))) return text("a map", limits.map(), "entries");
  if (is(static_cast<const str_size_overflow*>(nullptr))) return text("a text", limits.str(), "bytes");
  if (is(static_cast<const bin_size_overflow*>(nullptr))) return text("binary data", limits.bin(), "bytes");
  if (is(static_cast<const ext_size_overflow*>(nullptr))) return text("an extension", limits.ext(), "bytes");
  if (is(static_cast<const depth_size_overflow*>(nullptr))) return text("nesting", limits.depth(), "levels");
  return "";
}

/// Raised with what is wrong with a value; `decode` adds who sent it, in which kind and field.
struct WrongValue {
  std::string text;
};

std::string_view text_of(const Object& object) { return {object.via.str.ptr, object.via.str.size}; }

/// The words that a peer wrote, fit for an error text: it may be anything.
std::string quotable(std::string_view text) {
  std::string shown(text.substr(0, 60));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return shown;
}

std::string_view type_name(const Object& object) {
  switch (object.type) {
    case msgpack::type::NIL: return "nil";
    case msgpack::type::BOOLEAN: return "a boolean";
    case msgpack::type::POSITIVE_INTEGER:
    case msgpack::type::NEGATIVE_INTEGER: return "an integer";
    case msgpack::type::FLOAT32: return "a 32-bit float";
    case msgpack::type::FLOAT64: return "a 64-bit float";
    case msgpack::type::STR: return "a text";
    case msgpack::type::BIN: return "binary data";
    case msgpack::type::ARRAY: return "an array";
    case msgpack::type::MAP: return "a map";
    default: return "an extension";
  }
}

void require_type(const Object& object, msgpack::type::object_type type, std::string_view wanted) {
  if (object.type != type) throw WrongValue{fmt::format("is {}, expected {}", type_name(object), wanted)};
}

void read(const Object& object, Kind& value) {
  require_type(object, msgpack::type::STR, "a text");
  for (const Kind kind : all_kinds()) {
    value = kind;
    if (text_of(object) == name(kind)) return;
  }
  std::vector<std::string> names;
  for (const Kind kind : all_kinds()) names.emplace_back(name(kind));
  const auto found = quotable(text_of(object));
  throw WrongValue{
      fmt::format("is '{}', expected one of {}{}", found, fmt::join(names, ", "), did_you_mean(found, names))};
}

void read(const Object& object, bool& value) {
  require_type(object, msgpack::type::BOOLEAN, "a boolean");
  value = object.via.boolean;
}

void read(const Object& object, std::int64_t& value) {
  if (object.type == msgpack::type::NEGATIVE_INTEGER) {
    value = object.via.i64;
    return;
  }
  require_type(object, msgpack::type::POSITIVE_INTEGER, "an integer");
  if (object.via.u64 > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
    throw WrongValue{fmt::format("is {}, more than 64 bits with a sign can hold", object.via.u64)};
  }
  value = static_cast<std::int64_t>(object.via.u64);
}

template <class Value>
void refuse_not_finite(const Value& value) {
  if (const auto found = not_finite(value)) throw WrongValue{"is not finite: " + *found};
}

/// Encoders (msgpack-c among them) write a whole number as an integer.
void read(const Object& object, double& value) {
  if (object.type == msgpack::type::POSITIVE_INTEGER) {
    value = static_cast<double>(object.via.u64);
  } else if (object.type == msgpack::type::NEGATIVE_INTEGER) {
    value = static_cast<double>(object.via.i64);
  } else {
    require_type(object, msgpack::type::FLOAT64, "a number");
    value = object.via.f64;
  }
  refuse_not_finite(value);
}

void read(const Object& object, std::string& value) {
  require_type(object, msgpack::type::STR, "a text");
  value.assign(text_of(object));
}

void read(const Object& object, std::vector<std::string>& values) {
  require_type(object, msgpack::type::ARRAY, "an array of texts");
  values.resize(object.via.array.size);
  for (std::size_t i = 0; i < values.size(); ++i) read(object.via.array.ptr[i], values[i]);
}

const Object* find(const Object& map, std::string_view key) {
  for (const auto* pair = map.via.map.ptr; pair != map.via.map.ptr + map.via.map.size; ++pair) {
    if (pair->key.type == msgpack::type::STR && text_of(pair->key) == key) return &pair->val;
  }
  return nullptr;
}

/// One of the two numbers of a shape.
int extent(const Object& object) {
  if (object.type == msgpack::type::POSITIVE_INTEGER && object.via.u64 <= std::numeric_limits<int>::max()) {
    return static_cast<int>(object.via.u64);
  }
  throw WrongValue{"has a shape that is not two integers from 0 to 2^31 - 1"};
}

void read(const Object& object, Array& array) {
  require_type(object, msgpack::type::MAP, "a map of 'shape' and 'data'");
  const Object* shape = find(object, "shape");
  const Object* data = find(object, "data");
  if (!shape || !data || object.via.map.size != 2)
    throw WrongValue{"is a map of something else than 'shape' and 'data'"};
  if (shape->type != msgpack::type::ARRAY || shape->via.array.size != 2) {
    throw WrongValue{"has a shape that is not [rows, columns]"};
  }
  const int rows = extent(shape->via.array.ptr[0]);
  const int columns = extent(shape->via.array.ptr[1]);
  if (data->type != msgpack::type::BIN) {
    throw WrongValue{fmt::format("has data that are {}, expected binary data", type_name(*data))};
  }
  const std::uint32_t bytes = data->via.bin.size;
  const auto numbers = static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(columns);
  if (bytes % sizeof(double) != 0 || bytes / sizeof(double) != numbers) {
    throw WrongValue{fmt::format("has the shape {} x {} but {} bytes of data", rows, columns, bytes)};
  }
  array.resize(rows, columns);
  FiniteCheck check;  // in the loop that copies: large arrays come by once
  const char* from = data->via.bin.ptr;
  for (double& number : array.data) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, from, sizeof bits);
    from += sizeof bits;
    check.add(bits);
    number = std::bit_cast<double>(bits);
  }
  if (!check.all_finite()) refuse_not_finite(array);
}

void read(const Object& object, Bytes& bytes) {
  require_type(object, msgpack::type::BIN, "binary data");
  bytes.data.assign(object.via.bin.ptr, object.via.bin.size);
}

void read_field(const Object& object, const Field& field, Message& message) {
  std::visit([&](auto* value) { read(object, *value); }, field.in(message));
}

/// Fields of the header and of one kind as one list.
class FieldList {
 public:
  explicit FieldList(Kind kind) : header_(header_fields()), own_(fields_of(kind)) {}
  [[nodiscard]] std::size_t size() const { return header_.size() + own_.size(); }
  const Field& operator[](std::size_t i) const { return i < header_.size() ? header_[i] : own_[i - header_.size()]; }
  /// Index of a field; size() if there is none. Looks at `first` first: there it is if the sender keeps our order.
  [[nodiscard]] std::size_t find(std::string_view key, std::size_t first) const {
    for (std::size_t n = 0; n < size(); ++n) {
      const std::size_t i = (first + n) % size();
      if ((*this)[i].name == key) return i;
    }
    return size();
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < size(); ++i) all.emplace_back((*this)[i].name);
    return all;
  }

 private:
  const std::vector<Field>& header_;
  const std::vector<Field>& own_;
};

/// One decoding: knows whom and what to name in an error.
class Decoder {
 public:
  explicit Decoder(std::string_view sender) : sender_(sender) {}

  Object unpack(std::string_view bytes, msgpack::zone& zone) const;
  void check_version(const Object& map) const;
  [[nodiscard]] Kind kind_of(const Object& map) const;
  void read_all(const Object& map, Message& message) const;

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw ProtocolError(fmt::format("{} sent {}", sender_, what));
  }

  std::string_view sender_;
};

Object Decoder::unpack(std::string_view bytes, msgpack::zone& zone) const {
  if (has_too_many_values(bytes)) refuse(fmt::format("a message of more than {} values", most_values));
  std::size_t end = 0;
  bool referenced = false;
  const auto refer = [](msgpack::type::object_type, std::size_t, void*) {
    return true;
  };  // texts and data stay in `bytes`
  Object object;
  try {
    object = msgpack::unpack(zone, bytes.data(), bytes.size(), end, referenced, refer, nullptr, limits);
  } catch (const msgpack::insufficient_bytes&) {
    refuse(fmt::format("a message that breaks off after {} bytes", bytes.size()));
  } catch (const msgpack::unpack_error& error) {
    if (const auto beyond = size_beyond_limit(error); !beyond.empty()) refuse(beyond);
    refuse(fmt::format("{} bytes that are no message of this protocol ({})", bytes.size(), error.what()));
  }
  if (object.type != msgpack::type::MAP)
    refuse(fmt::format("{}, expected a message, which is a map", type_name(object)));
  if (end != bytes.size()) refuse(fmt::format("{} bytes after the end of a message", bytes.size() - end));
  return object;
}

/// Comes first: of a message of another version nothing else can be trusted to mean what it says.
void Decoder::check_version(const Object& map) const {
  const auto* object = find(map, "version");
  if (!object) refuse("a message without the field 'version'");
  std::int64_t version = 0;
  try {
    read(*object, version);
  } catch (const WrongValue& wrong) {
    refuse("a message whose field 'version' " + wrong.text);
  }
  if (version == protocol_version) return;
  throw ProtocolError(
      fmt::format("{} speaks version {} of the wire protocol, this program speaks version {}: use the same "
                  "release of ricochet on both ends",
                  sender_, version, protocol_version));
}

Kind Decoder::kind_of(const Object& map) const {
  const auto* object = find(map, "kind");
  if (!object) refuse("a message without the field 'kind'");
  Kind kind{};
  try {
    read(*object, kind);
  } catch (const WrongValue& wrong) {
    refuse("a message whose field 'kind' " + wrong.text);
  }
  return kind;
}

void Decoder::read_all(const Object& map, Message& message) const {
  const Kind kind = message.kind;
  const FieldList fields(kind);
  std::uint64_t seen = 0;
  std::size_t next = 0;
  for (const auto* pair = map.via.map.ptr; pair != map.via.map.ptr + map.via.map.size; ++pair) {
    if (pair->key.type != msgpack::type::STR) {
      refuse(fmt::format("'{}' with a field whose name is {}", name(kind), type_name(pair->key)));
    }
    const auto key = text_of(pair->key);
    const std::size_t i = fields.find(key, next);
    if (i == fields.size()) {
      refuse(fmt::format("'{}' with the unknown field '{}'{}", name(kind), quotable(key),
                         did_you_mean(quotable(key), fields.names())));
    }
    if ((seen >> i & 1U) != 0) refuse(fmt::format("'{}' with the field '{}' twice", name(kind), key));
    seen |= std::uint64_t{1} << i;
    next = i + 1;
    try {
      read_field(pair->val, fields[i], message);
    } catch (const WrongValue& wrong) {
      refuse(fmt::format("'{}' whose field '{}' {}", name(kind), key, wrong.text));
    }
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if ((seen >> i & 1U) == 0) refuse(fmt::format("'{}' without the field '{}'", name(kind), fields[i].name));
  }
}

}  // namespace

void decode(std::string_view bytes, std::string_view sender, Message& message) {
  thread_local msgpack::zone zone;  // kept, because a new one allocates
  zone.clear();
  const Decoder decoder(sender);
  const Object map = decoder.unpack(bytes, zone);
  decoder.check_version(map);
  message.kind = decoder.kind_of(map);
  decoder.read_all(map, message);  // all of its fields: nothing that was there before is left
}

}  // namespace ricochet::wire
