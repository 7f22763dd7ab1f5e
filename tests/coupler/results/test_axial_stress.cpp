// Adding up what the participants tell of the axial stress.
#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "coupler/results/axial_stress.hpp"

namespace ricochet::coupler {
namespace {

using testing::AllOf;
using testing::HasSubstr;

AxialStress axial_stress(const std::vector<std::string>& of_explicit, const std::vector<std::string>& of_implicit) {
  return {{{"explicit", of_explicit}, {"implicit", of_implicit}}, {"steel", "carbide"}};
}

std::string error(const std::vector<std::string>& columns) {
  try {
    axial_stress(columns, {});
  } catch (const ProtocolError& error) {
    return error.what();
  }
  return "no error";
}

TEST(AxialStress, SharesOfALayerAddUpInTheOrderOfTheBodies) {
  auto sum =
      axial_stress({"window", "carbide/0/1/1", "steel/-2/-1/0.25"}, {"window", "steel/-2/-1/0.75", "steel/-1/0/1"});
  sum.add(0, {0, 1, 2, 1, -3, 4e6});
  sum.add(1, {0, 10, 20, 1, 1e6, 40});
  EXPECT_EQ(sum.csv(0.5), "time_s,steel/-2/-1,steel/-1/0,carbide/0/1\n0,12,20,1\n0.5,5e+06,40,-3\n");
}

TEST(AxialStress, ALayerOfWhichSomethingIsMissingIsNotANumber) {
  auto sum = axial_stress({}, {"window", "steel/-2/-1/0.75", "steel/-1/0/1"});
  sum.add(0, {});
  sum.add(1, {0, 10, 20});
  EXPECT_EQ(sum.csv(0.5), "time_s,steel/-2/-1,steel/-1/0\n0,nan,20\n");
}

TEST(AxialStress, EndsWithTheLastTimeThatAllHaveTold) {
  auto sum = axial_stress({"window", "carbide/0/1/1"}, {"window", "steel/-1/0/1"});
  sum.add(0, {0, 1, 2, 2});
  sum.add(1, {0, 4, 2, 5, 4, 6});
  EXPECT_EQ(sum.csv(0.5), "time_s,steel/-1/0,carbide/0/1\n0,4,1\n1,5,2\n");
  sum.add(0, {4, 3});
  EXPECT_THAT(sum.csv(0.5), HasSubstr("\n2,6,3\n"));
}

TEST(AxialStress, NobodyTells) { EXPECT_FALSE(axial_stress({}, {}).told()); }

TEST(AxialStress, WrongColumnsAreNamed) {
  EXPECT_THAT(error({"window", "lead/0/1/1"}), AllOf(HasSubstr("'explicit'"), HasSubstr("\"lead/0/1/1\"")));
  EXPECT_THAT(error({"window", "steel/0/1"}), HasSubstr("\"steel/0/1\", expected BODY/LOW/HIGH/SHARE"));
  EXPECT_THAT(error({"window", "steel/0/x/1"}), HasSubstr("steel/0/x/1"));
  EXPECT_THAT(error({"steel/0/1/1"}), HasSubstr("must be \"window\""));
}

}  // namespace
}  // namespace ricochet::coupler
