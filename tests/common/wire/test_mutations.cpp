// Random damage to valid messages: either still a message, or refused; never a crash (run it with the sanitizers, too).
#include <gtest/gtest.h>

#include <random>

#include "common/base/error.hpp"
#include "tests/common/wire/samples.hpp"

namespace ricochet::wire {
namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t bound) {
  return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random);
}

/// Changes, removes, inserts, copies or cuts bytes in one place.
void damage(Random& random, std::string& bytes) {
  if (bytes.empty()) return;
  const std::size_t place = below(random, bytes.size());
  const std::size_t length = 1 + below(random, 8);
  switch (below(random, 6)) {
    case 0: bytes[place] = static_cast<char>(below(random, 256)); break;
    case 1: bytes[place] = static_cast<char>(bytes[place] ^ (1 << below(random, 8))); break;
    case 2: bytes.erase(place, length); break;
    case 3: bytes.insert(place, length, static_cast<char>(below(random, 256))); break;
    case 4: bytes.insert(place, bytes.substr(below(random, bytes.size()), 4 * length)); break;
    default: bytes.resize(place); break;
  }
}

TEST(Mutations, AreRefusedOrDecodedButNeverCrash) {
  Random random(20260101);
  std::vector<std::string> valid;
  for (const Kind kind : all_kinds()) valid.push_back(encoded(sample(kind)));
  Message message;
  int refused = 0;
  constexpr int rounds = 20'000;
  for (int round = 0; round < rounds; ++round) {
    std::string bytes = valid[below(random, valid.size())];
    for (std::size_t n = 1 + below(random, 3); n > 0; --n) damage(random, bytes);
    try {
      decode(bytes, "x", message);
      EXPECT_NO_THROW((void)encoded(message));  // what was let in can be sent on
    } catch (const ProtocolError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, rounds / 2);
  EXPECT_LT(refused, rounds);
}

}  // namespace
}  // namespace ricochet::wire
