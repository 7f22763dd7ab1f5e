#include <gtest/gtest.h>

#include "common/base/names.hpp"

namespace ricochet {
namespace {

const std::vector<std::string> keys{"penalty_pa_m", "friction_coefficient", "friction_law", "enforcement", "end_s"};

TEST(Nearest, FindsTheNameThatWasMeant) {
  EXPECT_EQ(nearest("penalty_pa", keys), "penalty_pa_m");
  EXPECT_EQ(nearest("frictoin_law", keys), "friction_law");
  EXPECT_EQ(nearest("Enforcement", keys), "enforcement");
  EXPECT_EQ(nearest("friction_coeficient", keys), "friction_coefficient");
  EXPECT_EQ(nearest("end", keys), "end_s");
}

TEST(Nearest, IsSilentWhenNothingIsNear) {
  EXPECT_EQ(nearest("colour", keys), "");
  EXPECT_EQ(nearest("", keys), "");
  EXPECT_EQ(nearest("x", {"y", "z"}), "");
  EXPECT_EQ(nearest("anything", {}), "");
}

TEST(Nearest, TakesTheFirstOfEquals) { EXPECT_EQ(nearest("abcd", {"abce", "abcf"}), "abce"); }

TEST(DidYouMean, MakesASentenceOrNothing) {
  EXPECT_EQ(did_you_mean("steal", {"steel", "carbide"}), "; did you mean \"steel\"?");
  EXPECT_EQ(did_you_mean("water", {"steel", "carbide"}), "");
  EXPECT_EQ(did_you_mean("steel", {"copper", "stainless_steel_304"}), "; did you mean \"stainless_steel_304\"?")
      << "as a word of it";
  EXPECT_EQ(did_you_mean("", {"stainless_steel_304"}), "");
}

}  // namespace
}  // namespace ricochet
