#pragma once

#include <variant>

#include "common/base/archive.hpp"
#include "common/wire/message.hpp"

namespace ricochet::fuzz {

inline void archive_field(Archive& a, wire::Bytes& bytes) { a(bytes.data); }
template <class Value>
void archive_field(Archive& a, Value& value) {
  a(value);
}

/// One message as the fuzzer sees it, between the bytes of others: its kind in a byte, what of its header may be
/// anything, and its own fields one after another. Names, types and counters, at which mutated bytes of the wire would
/// end, are left to the fuzzer of the decoder.
inline void archive(Archive& a, wire::Message& message) {
  auto kind = static_cast<std::uint8_t>(message.kind);
  a(kind);
  message.kind = wire::all_kinds()[kind % wire::all_kinds().size()];
  if (a.reading()) wire::clear_body(message);
  a(message.window, message.substep);
  for (const auto& field : wire::fields_of(message.kind))
    std::visit([&](auto* value) { archive_field(a, *value); }, field.in(message));
}

}  // namespace ricochet::fuzz
