#include <gtest/gtest.h>

#include "common/base/separation.hpp"

namespace ricochet {
namespace {

TEST(SeparationWatch, ABodyThatNeverTouchedIsNotSeparated) {
  SeparationWatch watch(3);
  for (int n = 1; n < 20; ++n) watch.update(n, 0, 0.1 * n);
  EXPECT_FALSE(watch.separated());
  EXPECT_LT(watch.separation_window(), 0);
}

TEST(SeparationWatch, NamesTheFirstWindowOfTheStreak) {
  SeparationWatch watch(3);
  watch.update(1, 4, 0.0);
  watch.update(2, 0, 0.1);
  watch.update(3, 0, 0.2);
  EXPECT_FALSE(watch.separated());
  watch.update(4, 0, 0.3);
  EXPECT_TRUE(watch.separated());
  EXPECT_EQ(watch.separation_window(), 2);
}

TEST(SeparationWatch, IsNotLateByTheRoundOffOfTheClosedGap) {
  SeparationWatch watch(3);
  watch.update(1, 1, 1e-19);
  watch.update(2, 0, 0.0);
  watch.update(3, 0, 0.1);
  watch.update(4, 0, 0.2);
  EXPECT_TRUE(watch.separated());
  EXPECT_EQ(watch.separation_window(), 2);
}

TEST(SeparationWatch, AShrinkingGapOrATouchStartsTheStreakAgain) {
  SeparationWatch watch(2);
  watch.update(1, 1, 0.0);
  watch.update(2, 0, 0.2);
  watch.update(3, 0, 0.1);  // approaching again
  watch.update(4, 0, 0.15);
  EXPECT_FALSE(watch.separated());
  watch.update(5, 1, 0.0);  // touching
  watch.update(6, 0, 0.1);
  watch.update(7, 0, 0.2);
  EXPECT_TRUE(watch.separated());
  EXPECT_EQ(watch.separation_window(), 6);
}

TEST(SeparationWatch, StaysSeparatedUntilTheNextContactAndCountsAnew) {
  SeparationWatch watch(1);
  watch.update(1, 1, 0.0);
  watch.update(2, 0, 0.1);
  watch.update(3, 0, 0.05);
  EXPECT_TRUE(watch.separated()) << "coming closer is not contact";
  watch.update(4, 2, 0.0);
  EXPECT_FALSE(watch.separated());
  watch.update(5, 0, 0.1);
  EXPECT_EQ(watch.separation_window(), 5);
}

}  // namespace
}  // namespace ricochet
