#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "coupler/stability/stability_axis.hpp"

namespace ricochet::coupler {
namespace {

using testing::HasSubstr;

std::vector<double> numbers(const Axis& axis) {
  std::vector<double> values;
  for (const auto& value : axis.values) values.push_back(std::get<double>(value));
  return values;
}

TEST(StabilityAxis, ReadsRangesAndLists) {
  EXPECT_THAT(numbers(parse_axis("--against", "coupling.substeps=1:5:3")), testing::ElementsAre(1, 3, 5));
  const auto axis = parse_axis("--against", "body.rod.material.youngs_modulus_pa=1e9:1e13:3:log");
  EXPECT_EQ(axis.key, "body.rod.material.youngs_modulus_pa");
  EXPECT_TRUE(axis.logarithmic);
  EXPECT_THAT(numbers(axis), testing::ElementsAre(1e9, testing::DoubleNear(1e11, 1.0), testing::DoubleNear(1e13, 1.0)));
  EXPECT_THAT(numbers(parse_step_axis("--sweep", "courant=0.5,0.999,1.001")), testing::ElementsAre(0.5, 0.999, 1.001));
  const auto words = parse_axis("--against", "coupling.protocol=kim,hughes_liu");
  EXPECT_EQ(text_of(words.values[1]), "hughes_liu");
}

std::string refused(Axis (*parse)(const std::string&, const std::string&), const std::string& text) {
  try {
    const Axis axis = parse("--sweep", text);
    return "read as " + axis.key;
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(StabilityAxis, RefusesWhatIsNone) {
  const auto axis = [](const std::string& text) { return refused(parse_axis, text); };
  for (const std::string text : {"time.step_s", "=1:2:3", "a.b=", "a.b=1:2", "a.b=1:2:3:log:5"}) {
    EXPECT_THAT(axis(text), HasSubstr("--sweep: found \"" + text + "\"")) << text;
    EXPECT_THAT(axis(text), HasSubstr("allowed: KEY=LOW:HIGH:COUNT"));
  }
  EXPECT_THAT(axis("a.b=1:2:x"), HasSubstr("LOW, HIGH and COUNT are numbers"));
  EXPECT_THAT(axis("a.b=2:1:3"), HasSubstr("LOW is less than HIGH"));
  EXPECT_THAT(axis("a.b=0:1:3:log"), HasSubstr("LOW is more than 0 for log"));
  EXPECT_THAT(axis("a.b=1:2:3:lin"), HasSubstr("\"lin\" is not log"));
  EXPECT_THAT(axis("a.b=1:2:1"), HasSubstr("COUNT is an integer from 2 to 1000"));
  EXPECT_THAT(axis("a.b=1:2:2.5"), HasSubstr("COUNT is an integer"));
  EXPECT_THAT(axis("a.b=1:2:1001"), HasSubstr("COUNT is an integer"));
  EXPECT_THAT(axis("a.b=kim,,hughes_liu"), HasSubstr("an empty value"));
  EXPECT_THAT(axis("a.b=kim,kim"), HasSubstr("kim a second time"));
}

TEST(StabilityAxis, RefusesStepsThatAreNone) {
  const auto step = [](const std::string& text) { return refused(parse_step_axis, text); };
  EXPECT_THAT(step("coupling.protocol=kim"), HasSubstr("allowed: courant (share of the critical time step"));
  EXPECT_THAT(step("courant=1.1,0.9"), HasSubstr("numbers > 0 that rise"));
  EXPECT_THAT(step("courant=0:1:3"), HasSubstr("numbers > 0 that rise"));
  EXPECT_THAT(step("time.step_s=long"), HasSubstr("numbers > 0 that rise"));
}

}  // namespace
}  // namespace ricochet::coupler
