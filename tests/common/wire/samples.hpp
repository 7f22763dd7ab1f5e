#pragma once

#include <gtest/gtest.h>

#include <string>

#include "common/wire/codec.hpp"
#include "common/wire/message.hpp"

namespace ricochet::wire {

/// Gives a member a value that no new message has; `n` makes it differ from the other members'.
inline void fill(Kind&, int) {}
inline void fill(bool& value, int) { value = true; }
inline void fill(std::int64_t& value, int n) { value = n % 2 == 0 ? 1000 + n : -7'000'000'000 - n; }
inline void fill(double& value, int n) { value = -1.0 / (3 + n); }
inline void fill(std::string& value, int n) { value = "text \xc3\xa9 " + std::to_string(n); }
inline void fill(std::vector<std::string>& values, int n) {
  values = {"", "one", std::string(300, static_cast<char>('a' + n % 26))};
}
inline void fill(Array& array, int n) {
  array.resize(n % 4, 3);
  for (std::size_t i = 0; i < array.data.size(); ++i) array.data[i] = 1e-300 * n + 0.1 * static_cast<double>(i);
}

inline void fill(Bytes& value, int n) {
  for (int i = 0; i < 300; ++i) value.data += static_cast<char>(i + n);
}

/// A message of `kind` with all its fields filled in.
inline Message sample(Kind kind) {
  Message message;
  message.kind = kind;
  int n = 1;
  for (const auto* fields : {&header_fields(), &fields_of(kind)}) {
    for (const auto& field : *fields) std::visit([&](auto* value) { fill(*value, n++); }, field.in(message));
  }
  message.version = protocol_version;
  return message;
}

inline bool same(const Array& a, const Array& b) {
  return a.rows == b.rows && a.columns == b.columns && a.data == b.data;
}
inline bool same(const Bytes& a, const Bytes& b) { return a.data == b.data; }
template <class Value>
bool same(const Value& a, const Value& b) {
  return a == b;
}

/// Header and body.
inline void expect_same(const Message& a, const Message& b) {
  ASSERT_EQ(a.kind, b.kind);
  for (const auto* fields : {&header_fields(), &fields_of(a.kind)}) {
    for (const auto& field : *fields) {
      std::visit(
          [&](const auto* value) {
            EXPECT_TRUE(same(*value, *std::get<decltype(value)>(field.of(b)))) << name(a.kind) << "." << field.name;
          },
          field.of(a));
    }
  }
}

inline std::string encoded(const Message& message) {
  msgpack::sbuffer buffer;
  encode(message, buffer);
  return {buffer.data(), buffer.size()};
}

}  // namespace ricochet::wire
