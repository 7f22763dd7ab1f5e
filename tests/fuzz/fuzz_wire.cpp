// The decoder of the wire. A message that it accepts is encoded again, and must then be read as the same bytes.
#include <cstdlib>

#include "common/wire/codec.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

std::string encoded(const ricochet::wire::Message& message) {
  msgpack::sbuffer buffer;
  ricochet::wire::encode(message, buffer);
  return {buffer.data(), buffer.size()};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static ricochet::wire::Message message, again;  // a channel uses one again, too
  return ricochet::fuzz::read_or_refuse([&] {
    ricochet::wire::decode(ricochet::fuzz::text_of(data, size), "the peer", message);
    const auto bytes = encoded(message);
    ricochet::wire::decode(bytes, "the peer", again);
    if (encoded(again) != bytes) std::abort();
  });
}
