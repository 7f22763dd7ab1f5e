// The arithmetic of error bars on sequences whose limit is known.
#include <gtest/gtest.h>

#include <cmath>

#include "coupler/study/error_bar.hpp"

namespace ricochet::coupler {
namespace {

/// Q(h) = 1 + h^order at h = 0.1, 0.2, 0.4: the true error is 0.1^order.
QuantityLevels sequence(double order) {
  const auto level = [order](double h) { return 1.0 + std::pow(h, order); };
  QuantityLevels levels{.run = level(0.1)};
  levels.coarse = level(0.2);
  levels.coarsest = level(0.4);
  return levels;
}

TEST(ErrorBar, IsTwiceTheErrorOfAFirstOrderSequence) {
  const auto bar = error_bar(sequence(1.0));
  EXPECT_NEAR(*bar.total, 0.2, 1e-12);
  EXPECT_NEAR(*bar.order, 1.0, 1e-12);
  EXPECT_EQ(bar.found, "converging");
}

TEST(ErrorBar, BelievesNoMoreThanFirstOrder) {
  const auto bar = error_bar(sequence(1.5));
  EXPECT_NEAR(*bar.order, 1.5, 1e-12);
  EXPECT_NEAR(*bar.total, 2.0 * (std::pow(0.2, 1.5) - std::pow(0.1, 1.5)), 1e-12);
}

TEST(ErrorBar, WithoutAnOrderIsTheSumOfBothDifferences) {
  auto levels = sequence(1.0);
  levels.coarsest = 1.05;  // d1 = -0.1, d2 = 0.15
  const auto bar = error_bar(levels);
  EXPECT_NEAR(*bar.total, 0.25, 1e-12);
  EXPECT_FALSE(bar.order);
  EXPECT_EQ(bar.found, "not converging");
  EXPECT_EQ(error_bar(sequence(3.0)).found, "not converging");  // too good to be true
}

/// d1 = -0.1, d2 = -0.11: as a front's stress.
TEST(ErrorBar, OfASlowSequenceIsOneAndAHalfTimesThatSum) {
  auto levels = sequence(1.0);
  levels.coarsest = *levels.coarse + 0.11;
  const auto bar = error_bar(levels);
  EXPECT_NEAR(*bar.total, 1.5 * 0.21, 1e-12);
  EXPECT_EQ(bar.found, "not converging");
}

TEST(ErrorBar, IsNeverBelowItsFloor) {
  QuantityLevels levels{.run = 1.0};
  levels.coarse = levels.coarsest = 1.0;
  levels.floor = 0.25;
  EXPECT_EQ(error_bar(levels).total, 0.25);
}

TEST(ErrorBar, TellsPartsApart) {
  auto levels = sequence(1.0);
  levels.coarse_mesh = 1.14;
  levels.coarse_baseline = 1.16;
  const auto bar = error_bar(levels);
  EXPECT_NEAR(*bar.space, 2.0 * 0.04, 1e-12);
  EXPECT_NEAR(*bar.time, 2.0 * 0.06, 1e-12);
  EXPECT_NEAR(*bar.coupling, 0.5 * 0.04, 1e-12);
  EXPECT_EQ(bar.unknown.at("contact_law"), "a companion run has no such value");
  levels.hybrid = false;
  EXPECT_EQ(error_bar(levels).coupling, 0.0);
}

TEST(ErrorBar, WithoutACoarserMeshKnowsTimeAlone) {
  QuantityLevels levels{.run = 1.0};
  levels.half_step = 0.99;
  levels.missing["total"] = "no coarser mesh";
  const auto bar = error_bar(levels);
  EXPECT_NEAR(*bar.time, 0.04, 1e-12);
  EXPECT_FALSE(bar.total);
  EXPECT_EQ(bar.unknown.at("total"), "no coarser mesh");
  EXPECT_EQ(bar.found, "time alone");
  levels.double_step = 1.02;
  EXPECT_NEAR(*error_bar(levels).time, 0.04, 1e-12);
}

}  // namespace
}  // namespace ricochet::coupler
