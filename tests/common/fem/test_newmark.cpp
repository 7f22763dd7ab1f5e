#include <gtest/gtest.h>

#include "common/fem/newmark.hpp"

namespace ricochet::fem {
namespace {

// u = 1, v = 2, a = 8 and dt = 1/2, by hand; one number is a vector of one.
TEST(Newmark, PredictsWithTheAccelerationsShareThatBetaLeaves) {
  EXPECT_EQ(predicted_displacement(1.0, 2.0, 8.0, 0.5, beta_explicit), 1.0 + 1.0 + 1.0);
  EXPECT_EQ(predicted_displacement(1.0, 2.0, 8.0, 0.5, beta_implicit), 1.0 + 1.0 + 0.5);
}

TEST(Newmark, CorrectsWithTheMeanOfBothAccelerations) {
  EXPECT_EQ(corrected_velocity(2.0, 8.0, 4.0, 0.5), 2.0 + 0.25 * 12.0);
}

}  // namespace
}  // namespace ricochet::fem
