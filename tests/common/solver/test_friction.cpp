#include <gtest/gtest.h>

#include <cmath>

#include "common/solver/friction.hpp"

namespace ricochet::solver {
namespace {

scene::Contact coulomb() {
  scene::Contact law;
  law.friction_law = scene::FrictionLaw::return_mapping;
  return law;
}

scene::Contact regularised(double xi_s_m) {
  scene::Contact law;
  law.friction_law = scene::FrictionLaw::regularised;
  law.friction_regularisation_s_m = xi_s_m;
  return law;
}

TEST(FrictionOfPair, HoldsWithinTheConeInEitherDirection) {
  EXPECT_EQ(friction_of_pair(coulomb(), 3.0, -1.0, 2.0), 2.0);
  EXPECT_EQ(friction_of_pair(coulomb(), 3.0, 1.0, -2.0), -2.0);
}

TEST(FrictionOfPair, SlipsOnTheConeInEitherDirection) {
  EXPECT_EQ(friction_of_pair(coulomb(), 3.0, -1.0, 5.0), 3.0);
  EXPECT_EQ(friction_of_pair(coulomb(), 3.0, 1.0, -5.0), -3.0);
  EXPECT_EQ(friction_of_pair(coulomb(), 0.0, 1.0, -5.0), 0.0) << "an open pair";
}

// t = -limit tanh(xi v) with the velocity that t itself leaves, v = free_rate (1 - t / holding).
TEST(FrictionOfPair, RegularisedSolvesItsEquationInEitherDirection) {
  for (const double xi : {0.01, 1.0, 1e3}) {
    for (const double free_rate : {-4.0, -1e-3, 2e-6, 0.7}) {
      const double limit = 3.0, holding = -0.5 * free_rate;
      const double t = friction_of_pair(regularised(xi), limit, free_rate, holding);
      EXPECT_NEAR(t, -limit * std::tanh(xi * free_rate * (1.0 - t / holding)), 1e-12 * limit) << xi << " " << free_rate;
      EXPECT_LT(t * free_rate, 0.0) << "it opposes the slip";
      EXPECT_LE(std::abs(t), std::abs(holding) * (1.0 + 1e-12)) << "it does not turn the slip round";
    }
  }
  EXPECT_EQ(friction_of_pair(regularised(1.0), 3.0, 0.0, 0.0), 0.0);
}

}  // namespace
}  // namespace ricochet::solver
