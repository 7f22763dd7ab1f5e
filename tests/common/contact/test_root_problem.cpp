#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/base/error.hpp"
#include "common/contact/root_problem.hpp"
#include "tests/common/contact/uniform_root.hpp"

namespace ricochet::solver {
namespace {

Eigen::MatrixXd random_compliance(int size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(size, size, [&] { return normal(random); });
  return a * a.transpose() + 0.5 * Eigen::MatrixXd::Identity(size, size);
}

Eigen::VectorXd random_vector(int size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(random); });
}

scene::Contact frictional(double mu) {
  scene::Contact law;
  law.friction_coefficient = mu;
  return law;
}

const Eigen::VectorXd none;

TEST(Compliance, PassesOverWhatHasNoForce) {
  const Eigen::MatrixXd half = Eigen::MatrixXd::Random(11, 11), dense = half * half.transpose();
  const Compliance compliance(dense);
  for (int forces = 0; forces <= 11; ++forces) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(11), y(11);
    for (int k = 0; k < forces; ++k) x[(5 * k + 3) % 11] = 1.0 + k;
    compliance.times(x, y);
    EXPECT_LT((y - dense * x).norm(), 1e-13 * (1.0 + y.norm())) << forces;
    Eigen::VectorXd by_columns = Eigen::VectorXd::Zero(11);
    for (int column = 0; column < 11; ++column) compliance.add_column(column, x[column], by_columns);
    EXPECT_LT((by_columns - y).norm(), 1e-13 * (1.0 + y.norm())) << forces;
  }
}

TEST(RootProblem, SolvesTheComplementarityProblemOfRandomCompliances) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + trial % 9;
    const Eigen::MatrixXd compliance = random_compliance(n, random);
    test::UniformRoot root(scene::Contact{}, compliance, std::vector<double>(static_cast<std::size_t>(n), 1.0), 1e-3);
    const Eigen::VectorXd gap_free = random_vector(n, random);
    const auto& solution = root.solve(gap_free, none, none, root.open());
    const Eigen::VectorXd gap = gap_free + compliance * solution.force;
    for (int i = 0; i < n; ++i) {
      EXPECT_GE(solution.force[i], -1e-10);
      EXPECT_GE(gap[i], -1e-10);
      EXPECT_NEAR(solution.force[i] * gap[i], 0.0, 1e-9);
      EXPECT_EQ(solution.states[static_cast<std::size_t>(i)] == ContactState::open, solution.force[i] == 0.0);
    }
  }
}

/// A corner in a floor and a wall: what is normal to one is along the other. The matrix of a corner that sticks to both
/// is singular, or by rounding nearly so.
TEST(RootProblem, SolvesACornerThatTwoContactsHoldAlongOneDirection) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Eigen::Index n = 4;  // pairs: of two nodes each the floor's and the wall's
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::MatrixXd half = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return uniform(random); });
    const Eigen::MatrixXd own = half * half.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * n, n);  // normal, then tangential
    for (Eigen::Index node = 0; node < 2; ++node) {
      rows(2 * node, 2 * node) = rows(n + 2 * node + 1, 2 * node) = 1.0;
      rows(2 * node + 1, 2 * node + 1) = rows(n + 2 * node, 2 * node + 1) = 1.0;
    }
    Eigen::MatrixXd compliance = rows * own * rows.transpose();
    for (double& entry : compliance.reshaped()) entry *= 1.0 + 2e-16 * uniform(random);
    std::vector<RootProblem::PairLaw> laws(n, {1.0, 0.2});
    laws[1].friction_coefficient = laws[3].friction_coefficient = 0.1 + 0.3 * std::abs(uniform(random));
    RootProblem root(scene::Contact{}, compliance, laws, 1e-3);
    const Eigen::VectorXd motion = Eigen::VectorXd::NullaryExpr(n, [&] { return uniform(random) - 0.5; });
    const Eigen::VectorXd free = rows * motion;
    Eigen::VectorXd slip = Eigen::VectorXd::Zero(2 * n);
    slip.head(n) = free.tail(n);
    const auto& found = root.solve(free.head(n), slip, Eigen::VectorXd::Zero(2 * n), root.open());
    ASSERT_TRUE(found.force.allFinite()) << trial;
    ASSERT_LE(found.residual, 1e-3) << trial;
  }
}

TEST(RootProblem, FrictionStaysInTheConeAndOpposesTheSlip) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + trial % 6;
    // Weak coupling between pairs, as lumped masses give; there the frictional problem has one solution.
    const Eigen::MatrixXd compliance =
        0.05 * random_compliance(2 * n, random) + 3.0 * Eigen::MatrixXd::Identity(2 * n, 2 * n);
    const double mu = 0.3;
    test::UniformRoot root(frictional(mu), compliance, std::vector<double>(static_cast<std::size_t>(n), 1.0), 1e-3);
    const Eigen::VectorXd gap_free = random_vector(n, random), slip_free = random_vector(n, random);
    const auto& solution = root.solve(gap_free, slip_free, Eigen::VectorXd::Zero(n), root.open());
    const Eigen::VectorXd motion = compliance * solution.force;
    for (int i = 0; i < n; ++i) {
      const double normal = solution.force[i], tangential = solution.force[n + i];
      const double slip = slip_free[i] + motion[n + i];
      EXPECT_GE(gap_free[i] + motion[i], -1e-9);
      EXPECT_LE(std::abs(tangential), mu * normal + 1e-9);
      switch (solution.states[static_cast<std::size_t>(i)]) {
        case ContactState::open: EXPECT_EQ(normal, 0.0); break;
        case ContactState::stick: EXPECT_NEAR(slip, 0.0, 1e-9); break;
        case ContactState::slip:
          EXPECT_NEAR(std::abs(tangential), mu * normal, 1e-9);
          EXPECT_LE(tangential * slip, 1e-9);
          break;
      }
    }
  }
}

/// Rows that move nearly the same nodes, as those about hanging nodes do. After a thousand sweeps bodies overlap as
/// deeply as without contact, and the last change is 1e-3 of the largest force.
TEST(RootProblem, NewtonsMethodGoesOnWhereSweepsDoNotSettle) {
  std::mt19937 random(23);
  const Eigen::VectorXd none(0);
  for (int trial = 0; trial < 20; ++trial) {
    constexpr int n = 24;
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd few = Eigen::MatrixXd::NullaryExpr(n, n / 2, [&] { return normal(random); });
    const Eigen::MatrixXd compliance = few * few.transpose() + 1e-3 * Eigen::MatrixXd::Identity(n, n);
    test::UniformRoot root(scene::Contact{}, compliance, std::vector<double>(n, 1.0), 1e-3);
    const Eigen::VectorXd gap_free = random_vector(n, random);
    const auto& solution = root.sweep_from_none(gap_free, none, none, false);
    EXPECT_LE(solution.residual, 1e-10);
    const Eigen::VectorXd gap = gap_free + compliance * solution.force;
    const double largest = solution.force.maxCoeff(), moved = compliance.diagonal().maxCoeff() * largest;
    EXPECT_GE(solution.force.minCoeff(), 0.0);
    EXPECT_GE(gap.minCoeff(), -1e-10 * moved);
    EXPECT_LE(solution.force.cwiseProduct(gap).cwiseAbs().maxCoeff(), 1e-10 * moved * largest);
  }
}

TEST(RootProblem, PairsThatAreFarApartChangeNoBitOfTheOthersForces) {
  std::mt19937 random(13);
  constexpr int n = 9;
  const std::vector<int> near{1, 4, 8}, unknowns{1, 4, 8, n + 1, n + 4, n + 8};
  const Eigen::MatrixXd compliance =
      0.05 * random_compliance(2 * n, random) + 3.0 * Eigen::MatrixXd::Identity(2 * n, 2 * n);
  Eigen::VectorXd gap_free = Eigen::VectorXd::Constant(n, 100.0);
  gap_free(near).setConstant(-1.0);
  const Eigen::VectorXd slip_free = random_vector(n, random), velocity = Eigen::VectorXd::Zero(n);
  test::UniformRoot all(frictional(0.3), compliance, std::vector<double>(n, 1.0), 1e-3);
  test::UniformRoot alone(frictional(0.3), Eigen::MatrixXd(compliance(unknowns, unknowns)), {1.0, 1.0, 1.0}, 1e-3);
  const auto& solution = all.solve(gap_free, slip_free, velocity, all.open());
  const auto& expected = alone.solve(gap_free(near), slip_free(near), velocity.head(3), alone.open());
  EXPECT_EQ(Eigen::VectorXd(solution.force(unknowns)), expected.force);
  EXPECT_GT(expected.force.head(3).minCoeff(), 0.1);
  EXPECT_EQ((solution.force.array() != 0.0).count(), (expected.force.array() != 0.0).count());
}

TEST(RootProblem, OnePairSticksBelowAndSlipsAboveTheCone) {
  const Eigen::MatrixXd compliance = 2.0 * Eigen::MatrixXd::Identity(2, 2);
  test::UniformRoot root(frictional(0.5), compliance, {1.0}, 1e-3);
  const Eigen::VectorXd gap = Eigen::VectorXd::Constant(1, -4.0), still = Eigen::VectorXd::Zero(1);
  auto solution = root.solve(gap, Eigen::VectorXd::Constant(1, 1.9), still, root.open());
  EXPECT_EQ(solution.states[0], ContactState::stick);
  EXPECT_DOUBLE_EQ(solution.force[0], 2.0);
  EXPECT_DOUBLE_EQ(solution.force[1], -0.95);
  solution = root.solve(gap, Eigen::VectorXd::Constant(1, 2.01), still, root.open());
  EXPECT_EQ(solution.states[0], ContactState::slip) << "by half a percent";
  EXPECT_LE(solution.iterations, 3);
  solution = root.solve(gap, Eigen::VectorXd::Constant(1, 2.1), still, solution);
  EXPECT_EQ(solution.states[0], ContactState::slip);
  EXPECT_DOUBLE_EQ(solution.force[1], -1.0);
  EXPECT_LE(solution.iterations, 3) << "found by its states, not by what is tried when they cycle";
  solution = root.solve(gap, Eigen::VectorXd::Constant(1, -2.1), still, solution);
  EXPECT_DOUBLE_EQ(solution.force[1], 1.0);
  EXPECT_LE(solution.iterations, 4);
}

TEST(RootProblem, APairHeldByItsSupportsSticksWithoutATangentialUnknown) {
  Eigen::MatrixXd compliance = Eigen::MatrixXd::Zero(2, 2);
  compliance(0, 0) = 2.0;
  test::UniformRoot root(frictional(0.1), compliance, {1.0}, 1e-3);
  const auto& solution =
      root.solve(Eigen::VectorXd::Constant(1, -4.0), Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1), root.open());
  EXPECT_DOUBLE_EQ(solution.force[0], 2.0);
  EXPECT_EQ(solution.force[1], 0.0);
  EXPECT_EQ(solution.states[0], ContactState::stick);
}

TEST(RootProblem, PenaltyForceIsPenaltyTimesAreaTimesPenetration) {
  scene::Contact law = frictional(0.4);
  law.enforcement = scene::Enforcement::penalty;
  law.penalty_pa_m = 3.0;
  const double area = 0.7;
  const Eigen::MatrixXd compliance = 0.2 * Eigen::MatrixXd::Identity(2, 2);
  test::UniformRoot root(law, compliance, {area}, 1e-3);
  RootProblem::Solution last = root.open();
  const auto& solution =
      root.solve(Eigen::VectorXd::Constant(1, -1.0), Eigen::VectorXd::Constant(1, 0.1), Eigen::VectorXd::Zero(1), last);
  const double gap = -1.0 + 0.2 * solution.force[0], slip = 0.1 + 0.2 * solution.force[1];
  EXPECT_NEAR(solution.force[0], -3.0 * area * gap, 1e-14);
  EXPECT_EQ(solution.states[0], ContactState::stick);
  EXPECT_NEAR(solution.force[1], -3.0 * area * slip, 1e-14);

  // A pair that stuck before remembers its spring: the slip of this window adds to the force of the last.
  last = solution;
  const double held = last.force[1];
  const auto& next = root.solve(Eigen::VectorXd::Constant(1, -1.0), Eigen::VectorXd::Constant(1, 0.01),
                                Eigen::VectorXd::Zero(1), last);
  EXPECT_EQ(next.states[0], ContactState::stick);
  EXPECT_NEAR(next.force[1], held - 3.0 * area * (0.01 + 0.2 * next.force[1]), 1e-14);
  EXPECT_LE(next.iterations, 1);
}

TEST(RootProblem, RegularisedFrictionSatisfiesItsEquation) {
  scene::Contact law = frictional(0.25);
  law.friction_law = scene::FrictionLaw::regularised;
  law.friction_regularisation_s_m = 0.8;
  const double dt = 0.1;
  Eigen::MatrixXd compliance(4, 4);
  compliance << 2, .1, .2, 0, .1, 2, 0, .2, .2, 0, 1.5, .1, 0, .2, .1, 1.5;
  test::UniformRoot root(law, Eigen::MatrixXd(0.01 * compliance), {1.0, 1.0}, dt);
  const Eigen::Vector2d gap_free(-0.05, -0.03), slip_free(0.02, -0.3), slip_velocity(0.4, -2.0);
  const auto& solution = root.solve(gap_free, slip_free, slip_velocity, root.open());
  const Eigen::VectorXd motion = 0.01 * compliance * solution.force;
  for (int i = 0; i < 2; ++i) {
    const double velocity = 2.0 * (slip_free[i] + motion[2 + i]) / dt - slip_velocity[i];
    EXPECT_GT(solution.force[i], 0.0);
    EXPECT_NEAR(solution.force[2 + i], -0.25 * solution.force[i] * std::tanh(0.8 * velocity), 1e-9);
  }
  EXPECT_LE(solution.iterations, 10) << "Newton's method found it";
}

TEST(RootProblem, HoldsEveryPairTogetherWhateverTheSignOfItsForce) {
  std::mt19937 random(5);
  const int n = 4;
  const Eigen::MatrixXd compliance = random_compliance(2 * n, random);
  test::UniformRoot root(frictional(0.1), compliance, std::vector<double>(n, 1.0), 1e-3);
  const Eigen::VectorXd gap = random_vector(n, random), slip = random_vector(n, random);
  const auto& held = root.hold(gap, slip);
  const Eigen::VectorXd motion = compliance * held.force;
  EXPECT_LT((gap + motion.head(n)).norm(), 1e-10);
  EXPECT_LT((slip + motion.tail(n)).norm(), 1e-10);
  EXPECT_LT(held.force.head(n).minCoeff(), 0.0) << "in tension, too";
  for (const auto state : held.states) EXPECT_EQ(state, ContactState::stick);
  EXPECT_EQ(root.spring(gap, slip).force.norm(), 0.0) << "a multiplier has no spring";
}

TEST(RootProblem, HoldsByItsSpringsWithAPenalty) {
  std::mt19937 random(6);
  const int n = 3;
  auto law = frictional(0.1);
  law.enforcement = scene::Enforcement::penalty;
  law.penalty_pa_m = 40.0;
  const double area = 0.5, stiffness = 20.0;
  const Eigen::MatrixXd compliance = random_compliance(2 * n, random);
  test::UniformRoot root(law, compliance, std::vector<double>(n, area), 1e-3);
  const Eigen::VectorXd gap = random_vector(n, random), slip = random_vector(n, random);
  const Eigen::VectorXd force = root.hold(gap, slip).force, motion = compliance * force;
  EXPECT_LT((force.head(n) + stiffness * (gap + motion.head(n))).norm(), 1e-9);
  EXPECT_LT((force.tail(n) + stiffness * (slip + motion.tail(n))).norm(), 1e-9);
  EXPECT_LT((root.spring(gap, slip).force.head(n) + stiffness * gap).norm(), 1e-12);
}

/// Conditions of the class comment, checked from the solution alone; the largest violation over the largest force.
double violation(const Eigen::MatrixXd& compliance, double mu, const Eigen::VectorXd& gap_free,
                 const Eigen::VectorXd& slip_free, const Eigen::VectorXd& force) {
  const auto n = gap_free.size();
  const Eigen::VectorXd motion = compliance * force;
  double worst = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double normal = force[i], tangential = force[n + i], limit = mu * normal;
    const double gap = (gap_free[i] + motion[i]) / compliance(i, i),
                 slip = (slip_free[i] + motion[n + i]) / compliance(n + i, n + i);
    worst = std::max({worst, -normal, -gap, std::min(normal, gap), std::abs(tangential) - limit});
    // Inside the cone no slip; on it the slip is against the force.
    if (std::abs(tangential) < limit - 1e-9)
      worst = std::max(worst, std::min(std::abs(slip), limit - std::abs(tangential)));
    else
      worst = std::max(worst, std::min(tangential * slip, std::abs(slip)));
  }
  return worst / force.head(n).maxCoeff();
}

/// Compliances so coupled, and friction so large, that the states of many of these problems cycle.
TEST(RootProblem, SolvesFrictionalProblemsWhoseStatesCycle) {
  std::mt19937 random(3);
  int cycled = 0, problems = 0;
  for (const double mu : {0.3, 1.0, 2.0}) {
    for (int trial = 0; trial < 300; ++trial) {
      const int n = 2 + trial % 8;
      const Eigen::MatrixXd compliance = 1e-9 * random_compliance(2 * n, random);  // m/N, as of steel
      test::UniformRoot root(frictional(mu), compliance, std::vector<double>(static_cast<std::size_t>(n), 1.0), 1e-3);
      const Eigen::VectorXd gap_free = 1e-6 * random_vector(n, random), slip_free = 1e-6 * random_vector(n, random);
      if (gap_free.minCoeff() > 0.0) continue;
      const auto& solution = root.solve(gap_free, slip_free, Eigen::VectorXd::Zero(n), root.open());
      ++problems;
      cycled += solution.iterations > 30;
      EXPECT_LT(solution.residual, 1e-8) << mu << ", trial " << trial;
      EXPECT_LT(violation(compliance, mu, gap_free, slip_free, solution.force), 1e-7) << mu << ", trial " << trial;
      EXPECT_NO_THROW(require_solved(solution));
    }
  }
  RecordProperty("cycled", cycled);
  EXPECT_GT(cycled, problems / 100) << "else this test shows nothing";
  EXPECT_LT(cycled, problems / 2);
}

TEST(RootProblem, SolvesRegularisedProblemsWhoseStatesCycle) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 2 + trial % 8;
    scene::Contact law = frictional(0.5);
    law.friction_law = scene::FrictionLaw::regularised;
    law.friction_regularisation_s_m = 1.0;
    const Eigen::MatrixXd compliance =
        1e-6 * (0.3 * random_compliance(2 * n, random) + 2.0 * Eigen::MatrixXd::Identity(2 * n, 2 * n));
    test::UniformRoot root(law, compliance, std::vector<double>(static_cast<std::size_t>(n), 1.0), 1e-3);
    const Eigen::VectorXd gap_free = 1e-3 * random_vector(n, random), slip_free = 1e-3 * random_vector(n, random);
    if (gap_free.minCoeff() > 0.0) continue;
    EXPECT_LT(root.solve(gap_free, slip_free, Eigen::VectorXd::Zero(n), root.open()).residual, 1e-8) << trial;
  }
}

/// Only products of D, and what bounds it.
Compliance products_of(const Eigen::MatrixXd& dense) {
  return {[dense](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y.noalias() = dense * x; },
          dense.cwiseAbs().rowwise().sum()};
}

/// Weakly coupled compliances, as those of lumped masses are: there the frictional problem has one solution.
TEST(RootProblem, ByProductsAloneSolvesWhatADenseComplianceSolves) {
  std::mt19937 random(12);
  for (const bool penalty : {false, true}) {
    for (const bool regularised : {false, true}) {
      for (int trial = 0; trial < 100; ++trial) {
        const int n = 1 + trial % 12;
        auto law = frictional(0.3);
        if (penalty) law.enforcement = scene::Enforcement::penalty;
        law.penalty_pa_m = 2.0;
        if (regularised) law.friction_law = scene::FrictionLaw::regularised;
        law.friction_regularisation_s_m = 0.5;
        const Eigen::MatrixXd dense =
            0.02 * random_compliance(2 * n, random) + 3.0 * Eigen::MatrixXd::Identity(2 * n, 2 * n);
        const std::vector<double> area(static_cast<std::size_t>(n), 1.0);
        test::UniformRoot root(law, dense, area, 1.0), by_products(law, products_of(dense), area, 1.0);
        auto last = root.open();
        for (int window = 0; window < 3; ++window) {
          const Eigen::VectorXd gap = random_vector(n, random), slip = random_vector(n, random),
                                rate = random_vector(n, random);
          const auto expected = root.solve(gap, slip, rate, last);
          const auto& found = by_products.solve(gap, slip, rate, last);
          EXPECT_LT((found.force - expected.force).norm(), 1e-9 * (1.0 + expected.force.norm())) << trial;
          EXPECT_EQ(found.states, expected.states) << trial;
          EXPECT_LT(found.residual, 1e-10);
          last = expected;
        }
        const Eigen::VectorXd gap = random_vector(n, random), slip = random_vector(n, random);
        const Eigen::VectorXd held = root.hold(gap, slip).force;
        EXPECT_LT((by_products.hold(gap, slip).force - held).norm(), 1e-9 * (1.0 + held.norm())) << trial;
      }
    }
  }
}

/// A compliance of pairs in a row, of which those far from each other hardly move each other.
Eigen::MatrixXd near_compliance(int pairs) {
  Eigen::MatrixXd d(2 * pairs, 2 * pairs);
  for (int i = 0; i < pairs; ++i) {
    for (int j = 0; j < pairs; ++j) {
      const double falls = std::pow(0.06, std::abs(i - j)), across = i == j ? 0.0 : i < j ? 0.2 : -0.2;
      d(i, j) = falls;
      d(pairs + i, pairs + j) = 1.3 * falls;
      d(i, pairs + j) = across * falls;
      d(pairs + j, i) = across * falls;
    }
  }
  return d;
}

/// The same matrix, once kept dense and factored, once sparse and solved by its products.
TEST(RootProblem, SparseComplianceGivesTheForcesOfTheDenseOne) {
  std::mt19937 random(5);
  const int n = 60;
  Eigen::MatrixXd dense = near_compliance(n);
  dense.row(n).setZero();  // a pair on the axis has no force along it
  dense.col(n).setZero();
  for (const bool penalty : {false, true}) {
    for (const bool regularised : {false, true}) {
      auto law = frictional(0.3);
      if (penalty) law.enforcement = scene::Enforcement::penalty;
      law.penalty_pa_m = 2.0;
      if (regularised) law.friction_law = scene::FrictionLaw::regularised;
      law.friction_regularisation_s_m = 0.5;
      const std::vector<double> area(static_cast<std::size_t>(n), 1.0);
      test::UniformRoot root(law, dense, area, 1.0), sparse(law, Compliance::Sparse(dense.sparseView()), area, 1.0);
      auto last = root.open();
      for (int window = 0; window < 10; ++window) {
        const Eigen::VectorXd gap = random_vector(n, random), slip = random_vector(n, random),
                              rate = random_vector(n, random);
        const auto expected = root.solve(gap, slip, rate, last);
        const auto& found = sparse.solve(gap, slip, rate, last);
        EXPECT_LT((found.force - expected.force).norm(), (regularised ? 1e-10 : 1e-12) * expected.force.norm());
        EXPECT_EQ(found.states, expected.states);
        EXPECT_EQ(found.force[n], 0.0);
        last = expected;
      }
      const Eigen::VectorXd gap = random_vector(n, random), slip = random_vector(n, random);
      const Eigen::VectorXd held = root.hold(gap, slip).force;
      EXPECT_LT((sparse.hold(gap, slip).force - held).norm(), 1e-12 * held.norm());
    }
  }
}

/// Its columns are had, so that one pair after the other is gone through.
TEST(RootProblem, SparseComplianceSweepsWhereStatesCycle) {
  std::mt19937 random(3);
  int cycled = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 2 + trial % 8;
    const Eigen::MatrixXd dense = 1e-9 * random_compliance(2 * n, random);
    test::UniformRoot root(frictional(1.0), Compliance::Sparse(dense.sparseView()),
                           std::vector<double>(static_cast<std::size_t>(n), 1.0), 1e-3);
    const Eigen::VectorXd gap_free = 1e-6 * random_vector(n, random), slip_free = 1e-6 * random_vector(n, random);
    if (gap_free.minCoeff() > 0.0) continue;
    const auto& solution = root.solve(gap_free, slip_free, Eigen::VectorXd::Zero(n), root.open());
    if (solution.iterations <= 30) continue;
    ++cycled;
    EXPECT_LT(solution.residual, 1e-10) << trial;
  }
  EXPECT_GT(cycled, 0) << "else this test shows nothing";
}

/// All pairs at once, where no column is had.
TEST(RootProblem, ByProductsAloneSweepsWhereStatesCycle) {
  std::mt19937 random(3);
  int cycled = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 2 + trial % 8;
    const Eigen::MatrixXd dense = 1e-9 * random_compliance(2 * n, random);
    test::UniformRoot root(frictional(1.0), products_of(dense), std::vector<double>(static_cast<std::size_t>(n), 1.0),
                           1e-3);
    const Eigen::VectorXd gap_free = 1e-6 * random_vector(n, random), slip_free = 1e-6 * random_vector(n, random);
    if (gap_free.minCoeff() > 0.0) continue;
    const auto& solution = root.solve(gap_free, slip_free, Eigen::VectorXd::Zero(n), root.open());
    if (solution.iterations <= 30) continue;
    ++cycled;
    EXPECT_LT(solution.residual, 1e-6) << trial;
  }
  RecordProperty("cycled", cycled);
  EXPECT_GT(cycled, 0) << "else this test shows nothing";
}

TEST(RootProblem, SaysWhatItCouldNotSolveAndStopsAboveAThousandth) {
  RootProblem::Solution solution{Eigen::VectorXd::Ones(1), {ContactState::slip}, 30, 0.9e-3};
  EXPECT_NO_THROW(require_solved(solution));
  solution.residual = 1.1e-3;
  EXPECT_THROW(require_solved(solution), SolverError);
}

}  // namespace
}  // namespace ricochet::solver
