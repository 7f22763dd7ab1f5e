// What survives in a checkpoint, written and read by the same list of members.
#include <gmock/gmock.h>

#include <cmath>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"

namespace ricochet {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Body {
  std::vector<double> u = {1.0, 2.0};
  std::optional<double> contact = 3.0;
  std::vector<int> found{};

  void archive(Archive& a) {
    a(u, contact);
    a.any_size(found);
  }
};

std::string written(Body body) {
  Archive out;
  out.same_size(body);
  return out.take();
}

/// What is said of `bytes` by who reads them into a new body.
std::string refusal(const std::string& bytes) {
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

TEST(Archive, ReadsWhatItHasWritten) {
  Body body;
  const std::string bytes = written({.u = {-0.0, 7.5}, .contact = 4.0, .found = {5, 6, 7}});
  Archive in(bytes, "the state");
  in.same_size(body);
  in.end();
  EXPECT_THAT(body.u, ElementsAre(0.0, 7.5));
  EXPECT_TRUE(std::signbit(body.u[0]));
  EXPECT_EQ(body.contact, 4.0);
  EXPECT_THAT(body.found, ElementsAre(5, 6, 7));
}

TEST(Archive, RefusesListsOfAnotherScene) {
  EXPECT_EQ(refusal(written({})), "none");
  EXPECT_EQ(refusal(written({.found = {1, 2, 3}})), "none");
  EXPECT_THAT(refusal(written({.u = {1.0}})), HasSubstr("the state: it is of another scene: a list of 1, expected 2"));
  EXPECT_THAT(refusal(written({.u = {1, 2, 3}})), HasSubstr("a list of 3, expected 2"));
  EXPECT_THAT(refusal(written({.contact = {}})), HasSubstr("the state: it is of another scene"));
}

TEST(Archive, RefusesBytesThatBreakOffOrGoOn) {
  const std::string bytes = written({});
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_THAT(refusal(bytes.substr(0, n)), HasSubstr("it breaks off")) << n;
  EXPECT_THAT(refusal(bytes + "x"), HasSubstr("1 bytes too many"));
}

}  // namespace
}  // namespace ricochet
