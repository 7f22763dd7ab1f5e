// docs/wire.md tells the schema, the legal order and an example as the code has them: nothing more, nothing less.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "common/wire/lifecycle.hpp"
#include "tests/common/wire/samples.hpp"
#include "tests/support/places.hpp"

namespace ricochet::wire {
namespace {

std::string page() {
  std::ifstream file(test::source_folder() + "/docs/wire.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The text between two marker lines.
std::string section(const std::string& name) {
  const std::string text = page(), begin = "<!-- begin " + name + " -->\n", end = "<!-- end " + name + " -->\n";
  const auto first = text.find(begin), last = text.find(end);
  if (first == std::string::npos || last == std::string::npos) return "no section " + name;
  return text.substr(first + begin.size(), last - first - begin.size());
}

/// The text belongs into the page; a failure leaves it in the build directory to copy from.
void expect_section(const std::string& name, const std::string& expected) {
  EXPECT_EQ(section(name), expected) << "docs/wire.md differs from the code; the right text is in "
                                     << test::build_folder() << "/wire_" << name << ".md";
  if (section(name) != expected) std::ofstream(fmt::format("{}/wire_{}.md", test::build_folder(), name)) << expected;
}

std::string type_of(const Field& field, Message& message) {
  const char* names[] = {"text", "boolean", "integer", "float", "text", "texts", "array", "bytes"};
  return names[field.in(message).index()];
}

/// `kind`: of a message that has the fields.
std::string table(const std::vector<Field>& fields, Kind kind) {
  if (fields.empty()) return "No fields besides the header.\n";
  std::string text = "| field | type | unit | meaning |\n|---|---|---|---|\n";
  Message message;
  message.kind = kind;
  for (const auto& field : fields) {
    text += fmt::format("| `{}` | {} | {} | {} |\n", field.name, type_of(field, message), field.unit, field.meaning);
  }
  return text;
}

std::string sender_of(Kind kind) {
  for (const auto& row : transitions()) {
    if (row.kind == kind) return row.sender == Side::coupler ? "From the coupler." : "From the participant.";
  }
  return "From either.";
}

TEST(WirePage, HasTheFieldsOfEveryMessage) {
  std::string text = "### Header\n\nIn every message.\n\n" + table(header_fields(), Kind::hello);
  for (const Kind kind : all_kinds()) {
    text += fmt::format("\n### `{}`\n\n{}\n\n{}", name(kind), sender_of(kind), table(fields_of(kind), kind));
  }
  expect_section("messages", text);
}

TEST(WirePage, HasTheLegalOrder) {
  std::string text = "| state | while ... | sender | message | next state |\n|---|---|---|---|---|\n";
  for (const auto& row : transitions()) {
    const char* acceptance[] = {"", ", `accept_at_once` true", ", `accept_at_once` false"};
    text += fmt::format("| {} | {} | {} | `{}`{} | {} |\n", name(row.state), phrase(row.state),
                        row.sender == Side::coupler ? "coupler" : "participant", name(row.kind),
                        acceptance[static_cast<int>(row.form)], name(row.next));
  }
  expect_section("order", text);
}

TEST(WirePage, NamesTheVersion) {
  EXPECT_THAT(page(), testing::HasSubstr(fmt::format("This page describes version {}.", protocol_version)));
}

/// JSON of a msgpack object, binary data as hexadecimal digits.
std::string json(const msgpack::object& object) {
  switch (object.type) {
    case msgpack::type::STR: return fmt::format("\"{}\"", object.as<std::string>());
    case msgpack::type::BIN: {
      std::string hex;
      for (const char c : object.as<std::vector<char>>()) hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
      return fmt::format("<{} bytes: {}>", object.via.bin.size, hex);
    }
    case msgpack::type::ARRAY: {
      std::vector<std::string> items;
      for (std::uint32_t i = 0; i < object.via.array.size; ++i) items.push_back(json(object.via.array.ptr[i]));
      return fmt::format("[{}]", fmt::join(items, ", "));
    }
    case msgpack::type::MAP: {
      std::vector<std::string> items;
      for (std::uint32_t i = 0; i < object.via.map.size; ++i) {
        items.push_back(json(object.via.map.ptr[i].key) + ": " + json(object.via.map.ptr[i].val));
      }
      return fmt::format("{{{}}}", fmt::join(items, ", "));
    }
    default: return fmt::format("{}", object.as<std::int64_t>());
  }
}

TEST(WirePage, HasAnExampleThatIsTrue) {
  Message message;
  message.kind = Kind::synchronise;
  message.run_id = "20260101-7f3a";
  message.sequence = 3;
  message.as<Synchronise>().integration = "explicit_central";
  message.as<Synchronise>().link_absolute.resize(2, 1);
  message.as<Synchronise>().link_absolute.data = {0.0, 1.5};
  const std::string bytes = encoded(message);
  std::string text = "```\n" + json(msgpack::unpack(bytes.data(), bytes.size()).get()) + "\n```\n\n```\n";
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    text += fmt::format("{:02x}{}", static_cast<unsigned char>(bytes[i]),
                        i % 32 == 31 || i + 1 == bytes.size() ? "\n" : " ");
  }
  expect_section("example", text + "```\n");
}

}  // namespace
}  // namespace ricochet::wire
