#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "tests/common/wire/samples.hpp"

namespace ricochet::wire {
namespace {

using testing::HasSubstr;

class EveryKind : public testing::TestWithParam<Kind> {};

TEST_P(EveryKind, ComesBackAsItWasSent) {
  const Message sent = sample(GetParam());
  Message received = sample(GetParam());  // what it held before must not shine through
  for (const auto& field : fields_of(GetParam())) std::visit([](auto* value) { fill(*value, 7); }, field.in(received));
  decode(encoded(sent), "x", received);
  expect_same(sent, received);
}

TEST_P(EveryKind, ComesBackWithEmptyFields) {
  Message sent, received = sample(GetParam());
  sent.kind = GetParam();
  decode(encoded(sent), "x", received);
  expect_same(sent, received);
}

TEST_P(EveryKind, DoesNotTravelWithANumberThatIsNotFinite) {
  const double wrong[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                          -std::numeric_limits<double>::infinity()};
  for (const auto& field : fields_of(GetParam())) {
    for (const double value : wrong) {
      Message message = sample(GetParam());
      const auto place = field.in(message);
      if (auto* const* number = std::get_if<double*>(&place)) {
        **number = value;
      } else if (auto* const* array = std::get_if<Array*>(&place)) {
        (*array)->resize(4, 3);
        (*array)->data[7] = value;
      } else {
        continue;
      }
      const auto expect_named = [&](const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("'" + std::string(field.name) + "'"));
        EXPECT_THAT(error.what(), HasSubstr(std::isnan(value) ? "nan" : "inf"));
        if (std::holds_alternative<Array*>(place)) {
          EXPECT_THAT(error.what(), HasSubstr("at row 2, column 1"));
        }
      };
      try {
        require_finite(message);
        FAIL() << field.name;
      } catch (const SolverError& error) {
        expect_named(error);
      }
      try {
        Message received;
        decode(encoded(message), "x", received);
        FAIL() << field.name;
      } catch (const ProtocolError& error) {
        expect_named(error);
      }
    }
  }
}

TEST_P(EveryKind, IsRefusedWhereverItBreaksOff) {
  const std::string bytes = encoded(sample(GetParam()));
  Message message;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(decode({bytes.data(), size}, "x", message), ProtocolError) << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Codec, EveryKind, testing::ValuesIn(all_kinds()),
                         [](const auto& param_info) { return std::string(name(param_info.param)); });

TEST(Decode, TakesFieldsInAnyOrder) {
  const Message sent = sample(Kind::advanced);
  const std::string bytes = encoded(sent);
  const auto handle = msgpack::unpack(bytes.data(), bytes.size());
  const auto& map = handle.get().via.map;
  msgpack::sbuffer buffer;
  msgpack::packer packer(buffer);
  packer.pack_map(map.size);
  for (std::uint32_t i = map.size; i > 0; --i) packer.pack(map.ptr[i - 1].key).pack(map.ptr[i - 1].val);
  Message received;
  decode({buffer.data(), buffer.size()}, "x", received);
  expect_same(sent, received);
}

TEST(Decode, UsesTheMemoryOfTheMessageAgain) {
  Message sent, received;
  sent.make<Advanced>().increment.resize(200, 2);
  decode(encoded(sent), "x", received);
  const auto* before = received.as<Advanced>().increment.data.data();
  decode(encoded(sent), "x", received);
  EXPECT_EQ(received.as<Advanced>().increment.data.data(), before);
}

TEST(Decode, TakesWholeNumbersThatTravelAsIntegers) {
  for (const double value : {0.0, 1.0, -3.0, 1e15, -1e15, 1e19, 0.5}) {
    Message sent, received;
    sent.make<Welcome>().timeout_s = value;
    const auto bytes = encoded(sent);
    const auto unpacked = msgpack::unpack(bytes.data(), bytes.size());
    msgpack::sbuffer by_others;
    msgpack::packer<msgpack::sbuffer>(by_others).pack(unpacked.get());  // which makes integers of whole numbers
    const std::string_view others(by_others.data(), by_others.size());
    EXPECT_EQ(others != bytes, value != 0.5);
    decode(others, "x", received);
    EXPECT_EQ(received.as<Welcome>().timeout_s, value);
  }
}

TEST_P(EveryKind, IsTheSameBytesInPieces) {
  Message message = sample(GetParam());
  for (const auto& field : fields_of(GetParam())) {
    const auto place = field.in(message);
    if (auto* const* array = std::get_if<Array*>(&place)) (*array)->resize(500, 3);
    if (auto* const* text = std::get_if<std::string*>(&place)) (*text)->assign(5000, 'x');
  }
  Pieces pieces;
  for (const auto& sent : {message, sample(GetParam())}) {
    encode(sent, pieces);
    std::string joined;
    for (const auto piece : pieces.in_order()) joined.append(piece);
    EXPECT_EQ(joined, encoded(sent));
  }
}

TEST(Encode, LeavesLargeArraysWhereTheyAre) {
  Message message;
  auto& increment = message.make<Advance>().link_increment;
  increment.resize(500, 3);
  Pieces pieces;
  encode(message, pieces);
  const std::string_view numbers{reinterpret_cast<const char*>(increment.data.data()), 500 * 3 * sizeof(double)};
  const auto is_the_array = [&](std::string_view piece) {
    return piece.data() == numbers.data() && piece.size() == numbers.size();
  };
  EXPECT_EQ(std::count_if(pieces.in_order().begin(), pieces.in_order().end(), is_the_array), 1);
}

/// On either side of what an exponent can hold.
TEST(Finite, IsWhatTheStandardLibrarySays) {
  using Limits = std::numeric_limits<double>;
  for (const double x : {0.0, 1.0, Limits::max(), Limits::denorm_min(), Limits::infinity(), Limits::quiet_NaN(),
                         Limits::signaling_NaN()}) {
    for (const double value : {x, std::copysign(x, -1.0)}) {
      const Array array{1, 3, {1.0, value, -1.0}};
      EXPECT_EQ(not_finite(array).has_value(), !std::isfinite(value)) << value;
    }
  }
}

/// Bit for bit, whatever an encoder would make of whole numbers.
TEST(Encode, KeepsWholeNumbers) {
  for (const double value : {0.0, -0.0, 1.0, -3.0, 0x1p53, 0x1p63, 0x1p64, -0x1p63, 1e300}) {
    Message sent, received;
    sent.make<Welcome>().timeout_s = value;
    decode(encoded(sent), "x", received);
    EXPECT_EQ(received.as<Welcome>().timeout_s, value);
    EXPECT_EQ(std::signbit(received.as<Welcome>().timeout_s), std::signbit(value));
  }
}

TEST(Encode, IsTheSameForTheSameMessage) {
  EXPECT_EQ(encoded(sample(Kind::description)), encoded(sample(Kind::description)));
}

}  // namespace
}  // namespace ricochet::wire
