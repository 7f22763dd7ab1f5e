#include <gmock/gmock.h>

#include "coupler/study/step_choice.hpp"

namespace ricochet::coupler {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;

TEST(CandidateSteps, AreWhereOtherElementsBecomeExplicit) {
  // 8.0 / 2 = 4.0 and 2.0 lie between the elements of 10 and 1: nothing changes there.
  EXPECT_THAT(candidate_steps({1.0, 10.0, 1.0, 10.0}, 8.0, 0.9), ElementsAre(8.0, DoubleEq(0.9)));
  EXPECT_THAT(candidate_steps({1.0, 2.0, 4.0, 8.0}, 8.0, 0.9),
              ElementsAre(8.0, DoubleEq(3.6), DoubleEq(1.8), DoubleEq(0.9)));
}

TEST(CandidateSteps, EndWithTheSmallestElementAndBeginWithTheLargestStep) {
  EXPECT_THAT(candidate_steps({3.0, 3.0}, 1.0, 0.9), ElementsAre(1.0)) << "everything is explicit at once";
  EXPECT_THAT(candidate_steps({3.0, 3.0}, 100.0, 0.9), ElementsAre(100.0, DoubleEq(2.7))) << "all implicit, or none";
  EXPECT_THAT(candidate_steps({5.0, 4.0}, 6.0, 0.9), ElementsAre(6.0, DoubleEq(4.5), DoubleEq(3.6)))
      << "less than half apart";
  EXPECT_THAT(candidate_steps({}, 1.0, 0.9), ElementsAre(1.0));
}

}  // namespace
}  // namespace ricochet::coupler
