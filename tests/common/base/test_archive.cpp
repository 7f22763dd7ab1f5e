#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"

namespace ricochet {
namespace {

using testing::HasSubstr;

enum class Colour { red, green };

struct Inner {
  double x = 0.0;
  std::vector<bool> flags;
  void archive(Archive& a) { a(x, flags); }
  bool operator==(const Inner&) const = default;
};

/// One of everything that states are made of.
struct Whole {
  int count = 0;
  std::int64_t window = 0;
  bool touched = false;
  Colour colour = Colour::red;
  std::string text;
  std::vector<double> numbers;
  std::vector<int> indices;
  std::deque<std::vector<double>> rows;
  std::array<double, 2> pair{};
  std::optional<Inner> some, none;
  std::variant<double, Inner> either = 0.0;
  void archive(Archive& a) {
    a(count, window, touched, colour, text, numbers, indices, rows, pair, some, none, either);
  }
  bool operator==(const Whole&) const = default;
};

Whole sample() {
  return {.count = -7,
          .window = std::int64_t{1} << 40,
          .touched = true,
          .colour = Colour::green,
          .text = std::string("a\0b", 3),
          .numbers = {0.1, -0.0, std::numeric_limits<double>::denorm_min(), HUGE_VAL},
          .indices = {3, -1},
          .rows = {{1.0}, {}, {2.0, 3.0}},
          .pair = {5.0, 6.0},
          .some = Inner{1.5, {true, false, true}},
          .none = {},
          .either = Inner{2.5, {}}};
}

std::string written(Whole whole) {
  Archive out;
  out(whole);
  return out.take();
}

TEST(Archive, GivesBackWhatWasWritten) {
  const auto bytes = written(sample());
  Whole read;
  read.none = Inner{};  // what is not there any more
  read.either = Inner{};
  Archive in(bytes, "the sample");
  in(read);
  in.end();
  EXPECT_EQ(read, sample());
  EXPECT_TRUE(std::signbit(read.numbers[1]));
  EXPECT_EQ(written(read), bytes);
}

TEST(Archive, RefusesBytesThatBreakOff) {
  const auto bytes = written(sample());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    Whole read;
    read.either = Inner{};
    Archive in(std::string_view(bytes).substr(0, size), "the sample");
    EXPECT_THROW(in(read), ConfigError) << size;
  }
}

template <class Read>
std::string refusal(std::string_view bytes, Read read) {
  try {
    Archive in(bytes, "the sample");
    read(in);
    in.end();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Archive, SaysWhatIsWrong) {
  const std::string huge(8, '\x7f');
  std::vector<double> numbers;
  EXPECT_EQ(refusal(huge, [&](Archive& in) { in(numbers); }),
            "the sample: it breaks off in 9187201950435737471 numbers");
  bool flag = false;
  EXPECT_EQ(refusal("\2", [&](Archive& in) { in(flag); }), "the sample: neither true nor false");
  EXPECT_EQ(refusal("\1\1", [&](Archive& in) { in(flag); }), "the sample: 1 bytes too many");
  double number = 0.0;
  EXPECT_EQ(refusal("abc", [&](Archive& in) { in(number); }), "the sample: it breaks off: 5 bytes are missing");
  std::variant<double, Inner> either = 0.0;
  EXPECT_EQ(refusal(std::string(16, '\1'), [&](Archive& in) { in(either); }), "the sample: another kind of state");
}

/// Some of it has one size in every state of a scene.
struct Body {
  std::vector<double> u = {1.0, 2.0};
  std::optional<double> contact = 3.0;
  std::vector<int> found{};

  void archive(Archive& a) {
    a(u, contact);
    a.any_size(found);
  }
};

std::string written_body(Body body) {
  Archive out;
  out.same_size(body);
  return out.take();
}

/// The words on `bytes` when they are read into a new body.
std::string refusal_of(const std::string& bytes) {
  Body body;
  Archive in(bytes, "the state");
  try {
    in.same_size(body);
    in.end();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "none";
}

TEST(Archive, RefusesListsOfAnotherScene) {
  EXPECT_EQ(refusal_of(written_body({})), "none");
  EXPECT_EQ(refusal_of(written_body({.found = {1, 2, 3}})), "none");
  EXPECT_THAT(refusal_of(written_body({.u = {1.0}})),
              HasSubstr("the state: it is of another scene: a list of 1, expected 2"));
  EXPECT_THAT(refusal_of(written_body({.u = {1, 2, 3}})), HasSubstr("a list of 3, expected 2"));
  EXPECT_THAT(refusal_of(written_body({.contact = {}})), HasSubstr("the state: it is of another scene"));
}

}  // namespace
}  // namespace ricochet
