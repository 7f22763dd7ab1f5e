#include <gtest/gtest.h>

#include <cmath>

#include "common/contact/friction.hpp"

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
  EXPECT_EQ(friction_of_pair(coulomb(), -3.0, 1.0, -5.0), 0.0) << "one that pulls";
  const Eigen::Vector2d along(0.6, -0.8);
  EXPECT_EQ(friction_of_pair(coulomb(), -3.0, along, -5.0 * along, Eigen::Matrix2d::Identity()).norm(), 0.0);
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

/// W of a pair whose masses are not alike along its two directions.
Eigen::Matrix2d uneven() { return (Eigen::Matrix2d() << 2.0, 0.7, 0.7, 0.5).finished(); }

TEST(FrictionOnTheCone, IsTheRadialReturnWhereMassesAreAlike) {
  const Eigen::Matrix2d inverse = 0.25 * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d rate(-0.75, 1.0), holding = holding_of_pair(inverse, rate);
  EXPECT_EQ(holding, Eigen::Vector2d(3.0, -4.0));
  EXPECT_EQ(friction_of_pair(coulomb(), 5.0, rate, holding, inverse), holding) << "on the cone's edge, bit for bit";
  EXPECT_LT((friction_of_pair(coulomb(), 2.0, rate, holding, inverse) - Eigen::Vector2d(1.2, -1.6)).norm(), 1e-15);
  EXPECT_EQ(friction_of_pair(coulomb(), 0.0, rate, holding, inverse).norm(), 0.0) << "an open pair";
}

TEST(FrictionOnTheCone, AlongOneDirectionIsThatOfTwoDimensions) {
  for (const int free : {0, 1}) {
    Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();
    inverse(free, free) = 0.5;
    const Eigen::Vector2d rate = -2.0 * Eigen::Vector2d::Unit(free), holding = holding_of_pair(inverse, rate);
    for (const auto& law : {coulomb(), regularised(0.7)}) {
      const Eigen::Vector2d t = friction_of_pair(law, 3.0, rate, holding, inverse);
      EXPECT_EQ(t[free], friction_of_pair(law, 3.0, -2.0, 4.0));
      EXPECT_EQ(t[1 - free], 0.0);
    }
  }
  EXPECT_EQ(friction_of_pair(coulomb(), 3.0, Eigen::Vector2d(1.0, 1.0), {0.0, 0.0}, Eigen::Matrix2d::Zero()).norm(),
            0.0);
}

/// v = free_rate + W t against t, on the cone; inside it v = 0.
TEST(FrictionOnTheCone, OpposesTheSlipThatItLeaves) {
  const Eigen::Matrix2d w = uneven();
  for (const double angle : {0.1, 1.0, 2.0, 3.0, 4.5}) {
    const Eigen::Vector2d rate = 1e-3 * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                          holding = holding_of_pair(w, rate);
    EXPECT_LT((rate + w * holding).norm(), 1e-17);
    EXPECT_EQ(friction_of_pair(coulomb(), 1.001 * holding.norm(), rate, holding, w), holding);
    for (const double share : {1e-6, 0.1, 0.5, 0.999}) {
      const double limit = share * holding.norm();
      const Eigen::Vector2d t = friction_of_pair(coulomb(), limit, rate, holding, w), v = rate + w * t;
      EXPECT_NEAR(t.norm(), limit, 1e-14 * limit) << share;
      EXPECT_NEAR(t.dot(v), -limit * v.norm(), 1e-12 * limit * rate.norm()) << share;
    }
    for (const double xi : {0.01, 1.0, 1e4}) {
      for (const double limit : {1e-6, 1e-3, 10.0}) {
        const Eigen::Vector2d t = friction_of_pair(regularised(xi), limit, rate, holding, w), v = rate + w * t;
        const Eigen::Vector2d expected = -limit * std::tanh(xi * v.norm()) * v.normalized();
        EXPECT_LT((t - expected).norm(), 1e-10 * std::min(limit, holding.norm())) << xi << " " << limit;
      }
    }
  }
}

/// Supports that leave a pair one direction of its own, along neither tangent nor binormal.
TEST(FrictionOnTheCone, ActsAlongTheOnlyFreeDirection) {
  const Eigen::Vector2d e(0.6, 0.8);
  const Eigen::Matrix2d w = 0.5 * e * e.transpose();
  const Eigen::Vector2d rate = -2.0 * e, holding = holding_of_pair(w, rate);
  EXPECT_LT((holding - 4.0 * e).norm(), 1e-13);
  EXPECT_LT((friction_of_pair(coulomb(), 3.0, rate, holding, w) - 3.0 * e).norm(), 1e-13);
  EXPECT_LT((friction_of_pair(regularised(1.0), 3.0, rate, holding, w) -
             friction_of_pair(regularised(1.0), 3.0, -2.0, 4.0) * e)
                .norm(),
            1e-12);
}

}  // namespace
}  // namespace ricochet::solver
