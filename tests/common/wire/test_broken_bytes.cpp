// Byte strings that are almost a message: each is refused with the name of the sender, the kind and the field.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>

#include "common/base/error.hpp"
#include "tests/common/wire/samples.hpp"
#include "tests/support/places.hpp"

namespace ricochet::wire {
namespace {

using testing::HasSubstr;
using Packer = msgpack::packer<msgpack::sbuffer>;

/// A message as a list of fields, each with its packed value.
using Entries = std::vector<std::pair<std::string, std::string>>;

template <class... Values>
std::string packed(const Values&... values) {
  msgpack::sbuffer buffer;
  Packer packer(buffer);
  (packer.pack(values), ...);
  return {buffer.data(), buffer.size()};
}

std::string packed_array(std::int64_t rows, std::int64_t columns, std::size_t bytes,
                         const std::vector<double>& data = {}) {
  msgpack::sbuffer buffer;
  Packer packer(buffer);
  packer.pack_map(2);
  packer.pack("shape").pack_array(2).pack(rows).pack(columns);
  packer.pack("data");
  std::string raw(reinterpret_cast<const char*>(data.data()), data.size() * sizeof(double));
  raw.resize(bytes);
  packer.pack_bin(static_cast<std::uint32_t>(bytes)).pack_bin_body(raw.data(), static_cast<std::uint32_t>(bytes));
  return {buffer.data(), buffer.size()};
}

Entries entries_of(const Message& message) {
  const std::string bytes = encoded(message);
  const auto handle = msgpack::unpack(bytes.data(), bytes.size());
  Entries entries;
  for (const auto& [key, value] : handle.get().as<std::map<std::string, msgpack::object>>()) {
    entries.emplace_back(key, packed(value));
  }
  return entries;
}

std::string joined(const Entries& entries) {
  std::string bytes;
  for (const auto& [key, value] : entries) bytes += packed(key) + value;
  return static_cast<char>(0x80 + entries.size()) + bytes;
}

/// The smallest message with an array and a text: ten fields at most, so that the map needs one byte.
Message good() {
  Message message;
  message.kind = Kind::synchronise;
  message.run_id = "run";
  message.as<Synchronise>().integration = "implicit_newmark";
  message.as<Synchronise>().link_absolute.resize(2, 1);
  return message;
}

std::string with(const std::string& field, const std::string& value) {
  Entries entries = entries_of(good());
  for (auto& [key, old] : entries) {
    if (key == field) old = value;
  }
  return joined(entries);
}

std::string without(const std::string& field) {
  Entries entries = entries_of(good());
  std::erase_if(entries, [&](const auto& entry) { return entry.first == field; });
  return joined(entries);
}

std::string and_also(const std::string& field, const std::string& value) {
  Entries entries = entries_of(good());
  entries.emplace_back(field, value);
  return joined(entries);
}

struct Broken {
  std::string name;
  std::string bytes;
  std::vector<std::string> says;
};

void PrintTo(const Broken& broken, std::ostream* out) { *out << broken.name; }

const double nan_value = std::nan("");
const std::string in_array = "'synchronise' whose field 'link_absolute'";

const std::vector<Broken> broken_bytes{
    {"empty", "", {"breaks off after 0 bytes"}},
    {"not_msgpack", "\xc1", {"1 bytes that are no message"}},
    {"a_number", packed(3), {"an integer", "a map"}},
    {"a_text", packed("hello"), {"a text", "a map"}},
    {"an_array", packed(std::vector<int>{1, 2}), {"an array", "a map"}},
    {"empty_map", "\x80", {"without the field 'version'"}},
    {"bytes_left_over", joined(entries_of(good())) + "ab", {"2 bytes after the end"}},
    {"two_messages", joined(entries_of(good())) + joined(entries_of(good())), {"bytes after the end"}},
    {"unknown_field", and_also("colour", packed(1)), {"'synchronise' with the unknown field 'colour'"}},
    {"unknown_field_nearly_right", and_also("link_absolut", packed(1)), {"did you mean \"link_absolute\"?"}},
    {"field_of_another_kind", and_also("error_text", packed("x")), {"the unknown field 'error_text'"}},
    {"unprintable_field", and_also("a\x01\xff", packed(1)), {"the unknown field 'a\?\?'"}},
    {"field_twice", and_also("integration", packed("explicit_central")), {"the field 'integration' twice"}},
    {"version_twice", and_also("version", packed(1)), {"the field 'version' twice"}},
    {"key_is_a_number",
     "\x89" + joined(entries_of(good())).substr(1) + packed(5, 5),
     {"a field whose name is an integer"}},
    {"no_version", without("version"), {"without the field 'version'"}},
    {"other_version", with("version", packed(3)), {"speaks version 3", "speaks version 7", "same release"}},
    {"version_is_text", with("version", packed("1")), {"'version' is a text, expected an integer"}},
    {"no_kind", without("kind"), {"without the field 'kind'"}},
    {"unknown_kind", with("kind", packed("synchronize")), {"'kind' is 'synchronize'", "did you mean \"synchronise\"?"}},
    {"kind_is_a_number", with("kind", packed(6)), {"'kind' is an integer, expected a text"}},
    {"no_run_id", without("run_id"), {"'synchronise' without the field 'run_id'"}},
    {"no_sequence", without("sequence"), {"without the field 'sequence'"}},
    {"no_array", without("link_absolute"), {"without the field 'link_absolute'"}},
    {"integer_is_float", with("window", packed(1.5)), {"'window' is a 64-bit float, expected an integer"}},
    {"integer_is_nil", with("window", packed(msgpack::type::nil_t())), {"'window' is nil"}},
    {"integer_is_boolean", with("window", packed(true)), {"'window' is a boolean"}},
    {"integer_too_large",
     with("window", packed(std::uint64_t{1} << 63)),
     {"'window' is 9223372036854775808, more than"}},
    {"text_is_binary", with("run_id", std::string("\xc4\x01x", 3)), {"'run_id' is binary data, expected a text"}},
    {"text_is_array", with("run_id", packed(std::vector<int>{})), {"'run_id' is an array"}},
    {"array_is_text", with("link_absolute", packed("1 2")), {in_array + " is a text, expected a map"}},
    {"array_is_array", with("link_absolute", packed(std::vector<double>{1, 2})), {in_array + " is an array"}},
    {"array_without_shape", with("link_absolute", packed(std::map<std::string, int>{{"data", 1}})), {"something else"}},
    {"array_with_other_keys",
     with("link_absolute", packed(std::map<std::string, int>{{"data", 1}, {"rows", 1}})),
     {"something else than 'shape' and 'data'"}},
    {"array_with_three_entries",
     with("link_absolute", packed(std::map<std::string, int>{{"data", 1}, {"shape", 1}, {"unit", 1}})),
     {"something else"}},
    {"shape_is_a_number",
     with("link_absolute", packed(std::map<std::string, int>{{"data", 1}, {"shape", 2}})),
     {in_array + " has a shape that is not [rows, columns]"}},
    {"shape_has_three_extents",
     with("link_absolute", packed(std::map<std::string, std::vector<int>>{{"data", {}}, {"shape", {1, 2, 3}}})),
     {"has a shape that is not [rows, columns]"}},
    {"data_is_an_array",
     with("link_absolute", packed(std::map<std::string, std::vector<int>>{{"data", {1, 2}}, {"shape", {2, 1}}})),
     {"has data that are an array, expected binary data"}},
    {"extent_is_float",
     with("link_absolute", packed(std::map<std::string, std::vector<double>>{{"data", {1}}, {"shape", {2.5, 1}}})),
     {in_array + " has a shape that is not two integers from 0"}},
    {"negative_extents", with("link_absolute", packed_array(-1, -2, 16)), {"a shape that is not two integers"}},
    {"huge_extent",
     with("link_absolute", packed_array(std::int64_t{1} << 40, 0, 0)),
     {"a shape that is not two integers"}},
    {"shape_overflows",
     with("link_absolute", packed_array(2147483647, 2147483647, 8)),
     {"2147483647 x 2147483647 but 8"}},
    {"too_little_data", with("link_absolute", packed_array(2, 1, 8)), {in_array + " has the shape 2 x 1 but 8 bytes"}},
    {"too_much_data", with("link_absolute", packed_array(2, 1, 24)), {"has the shape 2 x 1 but 24 bytes"}},
    {"odd_data", with("link_absolute", packed_array(2, 1, 17)), {"has the shape 2 x 1 but 17 bytes"}},
    {"nan_in_array",
     with("link_absolute", packed_array(2, 1, 16, {0.0, nan_value})),
     {in_array, "not finite: nan at row 1, column 0"}},
    {"inf_in_array",
     with("link_absolute", packed_array(1, 2, 16, {0.0, HUGE_VAL})),
     {"not finite: inf at row 0, column 1"}},
    {"array_of_4_billion", "\xdd\xff\xff\xff\xff", {"an array beyond the limit, allowed are 65536 values"}},
    {"map_of_4_billion", "\xdf\xff\xff\xff\xff", {"a map beyond the limit, allowed are 256 entries"}},
    {"binary_of_4_gigabytes", "\xc6\xff\xff\xff\xff", {"breaks off after 5 bytes"}},
    {"nested_too_deeply", std::string(1000, '\x91'), {"nesting beyond the limit, allowed are 4 levels"}},
    {"extension", with("window", std::string("\xd4\x05x", 3)), {"an extension beyond the limit, allowed are 0 bytes"}},
};

class BrokenBytes : public testing::TestWithParam<Broken> {};

TEST_P(BrokenBytes, AreRefusedByName) {
  Message message;
  try {
    decode(GetParam().bytes, "participant 'rod'", message);
    FAIL() << "accepted";
  } catch (const ProtocolError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("participant 'rod' s"));
    for (const auto& part : GetParam().says) EXPECT_THAT(error.what(), HasSubstr(part));
  }
}

INSTANTIATE_TEST_SUITE_P(Decode, BrokenBytes, testing::ValuesIn(broken_bytes),
                         [](const auto& param_info) { return param_info.param.name; });

TEST(Decode, TakesTheMessageThatWasNotBroken) {
  Message message;
  decode(joined(entries_of(good())), "x", message);
  expect_same(message, good());
}

/// The types that `synchronise` does not have.
/// A byte each on the wire, 24 in memory.
TEST(Decode, RefusesValuesByTheHundredThousandBeforeTheyTakeMemory) {
  const auto error_of = [](const std::string& bytes) -> std::string {
    Message message;
    try {
      decode(bytes, "x", message);
    } catch (const ProtocolError& error) {
      return error.what();
    }
    return "";
  };
  std::string many = packed(std::map<std::string, std::vector<int>>{{"a", std::vector<int>(60'000, 1)},
                                                                    {"b", std::vector<int>(60'000, 300)},
                                                                    {"c", std::vector<int>(60'000, 70'000)}});
  EXPECT_THAT(error_of(many), HasSubstr("x sent a message of more than 131072 values"));
  EXPECT_THAT(error_of(packed(std::vector<double>(131'073, 0.5))), HasSubstr("a message of more than 131072 values"));
  EXPECT_THAT(error_of(packed(std::vector<std::string>(50'000, "text"))), HasSubstr("an array, expected a message"));
  EXPECT_THAT(error_of(packed(std::string(200'000, 'x'))), HasSubstr("a text, expected a message"));
  EXPECT_THAT(error_of(packed(std::vector<int>(65'537, 1))),
              HasSubstr("an array beyond the limit, allowed are 65536 values"));
  std::map<int, int> map;
  for (int i = 0; i < 257; ++i) map[i] = i;
  EXPECT_THAT(error_of(packed(map)), HasSubstr("a map beyond the limit, allowed are 256 entries"));
  EXPECT_THAT(error_of(packed(std::string(1U << 25, 'x'))),
              HasSubstr("a text beyond the limit, allowed are 16777216 bytes"));
  EXPECT_THAT(error_of("\x91\x91\x91\x91\x91\x91\x91\x01"),
              HasSubstr("nesting beyond the limit, allowed are 4 levels"));
}

TEST(Decode, RefusesWrongTypesOfTheOtherFields) {
  const auto refused = [](Kind kind, const std::string& field, const std::string& value, const std::string& says) {
    const std::string bytes = encoded(sample(kind));
    const auto handle = msgpack::unpack(bytes.data(), bytes.size());
    msgpack::sbuffer buffer;
    Packer packer(buffer);
    packer.pack_map(handle.get().via.map.size);
    for (const auto* pair = handle.get().via.map.ptr; pair != handle.get().via.map.ptr + handle.get().via.map.size;
         ++pair) {
      packer.pack(pair->key);
      const bool spoil = pair->key.as<std::string>() == field;
      spoil ? buffer.write(value.data(), value.size()) : void(packer.pack(pair->val));
    }
    Message message;
    try {
      decode({buffer.data(), buffer.size()}, "x", message);
      FAIL() << field;
    } catch (const ProtocolError& error) {
      EXPECT_THAT(error.what(), HasSubstr("field '" + field + "' " + says));
    }
  };
  refused(Kind::advance, "accept_at_once", packed(1), "is an integer, expected a boolean");
  refused(Kind::welcome, "timeout_s", packed(true), "is a boolean, expected a number");
  refused(Kind::welcome, "timeout_s", packed("60"), "is a text, expected a number");
  refused(Kind::welcome, "timeout_s", packed(0.5F), "is a 32-bit float, expected a number");
  refused(Kind::welcome, "timeout_s", packed(nan_value), "is not finite: nan");
  refused(Kind::description, "bodies", packed("rod"), "is a text, expected an array of texts");
  refused(Kind::description, "bodies", packed(std::vector<int>{1}), "is an integer, expected a text");
}

/// A format that changes leaves seeds behind that are refused at once, and the fuzzer nothing to begin with.
TEST(Decode, ReadsTheSeedsOfItsFuzzer) {
  for (const Kind kind : all_kinds()) {
    std::ifstream file(fmt::format("{}/tests/fuzz/seeds/wire/{}", test::source_folder(), name(kind)), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    Message message;
    EXPECT_NO_THROW(decode(bytes, "x", message)) << name(kind);
    EXPECT_EQ(message.kind, kind);
    EXPECT_EQ(message.version, protocol_version) << name(kind);
  }
}

}  // namespace
}  // namespace ricochet::wire
