#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/contact/root_problem.hpp"
#include "tests/common/contact/uniform_root.hpp"

// Contact problems of solids: two tangential directions on the circular cone. Ordering: normals, along t, along n x t.

namespace ricochet::solver {
namespace {

struct ConeProblem {
  Eigen::MatrixXd compliance;
  Eigen::VectorXd gap_free, slip_free, slip_velocity;

  /// Random numbers; `coupling` of the pairs against what each does to itself.
  ConeProblem(int pairs, double coupling, double unit_m, std::mt19937& random) {
    std::normal_distribution<double> normal;
    const auto draw = [&](int rows, int columns) {
      return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }).eval();
    };
    const Eigen::MatrixXd a = draw(3 * pairs, 3 * pairs);
    compliance = coupling * a * a.transpose() + Eigen::MatrixXd::Identity(3 * pairs, 3 * pairs);
    gap_free = unit_m * draw(pairs, 1);
    slip_free = unit_m * draw(2 * pairs, 1);
    slip_velocity = draw(2 * pairs, 1);
  }
  [[nodiscard]] int pairs() const { return static_cast<int>(gap_free.size()); }
  [[nodiscard]] std::vector<double> areas() const { return std::vector<double>(gap_free.size(), 1.0); }
  [[nodiscard]] Eigen::Vector2d along(int pair, const Eigen::VectorXd& x) const {
    return {x[pairs() + pair], x[2 * pairs() + pair]};
  }
  /// Largest violation of Coulomb's law and of the gap's conditions over the largest force, from the forces alone.
  [[nodiscard]] double violation(double mu, const Eigen::VectorXd& force) const {
    const Eigen::VectorXd motion = compliance * force;
    double worst = 0.0;
    for (int i = 0; i < pairs(); ++i) {
      const double normal = force[i], gap = (gap_free[i] + motion[i]) / compliance(i, i);
      const Eigen::Vector2d tangential = along(i, force);
      const Eigen::Vector2d slip = (Eigen::Vector2d(slip_free[i], slip_free[pairs() + i]) + along(i, motion)) /
                                   compliance(pairs() + i, pairs() + i);
      worst = std::max({worst, -normal, -gap, std::min(normal, gap), tangential.norm() - mu * normal});
      // mu lambda |slip| + tau . slip = 0: no slip, or the whole limit straight against it.
      worst = std::max(worst, normal > 0.0 ? (mu * normal * slip.norm() + tangential.dot(slip)) / normal : 0.0);
    }
    return worst / force.head(pairs()).maxCoeff();
  }
};

scene::Contact cone_law(double mu) {
  scene::Contact law;
  law.friction_coefficient = mu;
  return law;
}

TEST(RootCone, OnePairSticksInsideAndSlipsOnTheCircularCone) {
  const Eigen::MatrixXd compliance = 2.0 * Eigen::MatrixXd::Identity(3, 3);
  test::UniformRoot root(cone_law(0.5), compliance, {1.0}, 1e-3);
  const Eigen::VectorXd gap = Eigen::VectorXd::Constant(1, -4.0), still = Eigen::VectorXd::Zero(2);
  auto solution = root.solve(gap, Eigen::Vector2d(1.14, 1.52), still, root.open());
  EXPECT_EQ(solution.states[0], ContactState::stick) << "1.9 m on 2 m/N against half of 2 N";
  EXPECT_DOUBLE_EQ(solution.force[0], 2.0);
  EXPECT_NEAR(solution.force[1], -0.57, 1e-15);
  EXPECT_NEAR(solution.force[2], -0.76, 1e-15);
  // 1.5 along each: inside the square that holds the disc, outside the disc
  solution = root.solve(gap, Eigen::Vector2d(1.5, 1.5), still, solution);
  EXPECT_EQ(solution.states[0], ContactState::slip);
  EXPECT_NEAR(solution.force[1], -std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(solution.force[2], -std::sqrt(0.5), 1e-15);
  solution = root.solve(gap, Eigen::Vector2d(-30.0, 40.0), still, solution);
  EXPECT_NEAR(solution.force[1], 0.6, 1e-15) << "against the slip, wherever it went before";
  EXPECT_NEAR(solution.force[2], -0.8, 1e-15);
  EXPECT_LE(solution.iterations, 10);
}

/// From weak coupling, as of lumped masses, to one as strong as what a pair does to itself.
TEST(RootCone, SolvesRandomProblemsToTheirConditions) {
  std::mt19937 random(3);
  int problems = 0, by_newton = 0;
  for (const double coupling : {0.02, 2.0}) {
    for (const double mu : {0.1, 0.3, 1.0, 2.0}) {
      for (int trial = 0; trial < 300; ++trial) {
        ConeProblem p(2 + trial % 8, coupling, 1e-6, random);
        p.compliance *= 1e-9;  // m/N, as of steel
        if (p.gap_free.minCoeff() > 0.0) continue;
        test::UniformRoot root(cone_law(mu), p.compliance, p.areas(), 1e-3);
        const auto& solution = root.solve(p.gap_free, p.slip_free, p.slip_velocity, root.open());
        ++problems;
        by_newton += solution.iterations < 30;
        EXPECT_LT(solution.residual, 1e-10) << coupling << ' ' << mu << ' ' << trial;
        EXPECT_LT(p.violation(mu, solution.force), 1e-9) << coupling << ' ' << mu << ' ' << trial;
      }
    }
  }
  RecordProperty("problems", problems);
  RecordProperty("by_newton", by_newton);
  EXPECT_GT(by_newton, 95 * problems / 100);
  EXPECT_LT(by_newton, problems) << "else the sweeps are not tried";
}

/// Pairs with much friction are coupled until a solution need not exist: what is not found is said.
TEST(RootCone, SaysWhatItDidNotFind) {
  std::mt19937 random(3);
  int problems = 0, found = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const ConeProblem p(20, 2.0, 1e-6, random);
    test::UniformRoot root(cone_law(5.0), p.compliance, p.areas(), 1e-3);
    const auto& solution = root.solve(p.gap_free, p.slip_free, p.slip_velocity, root.open());
    ++problems;
    found += solution.residual < 1e-10;
    const double violation = p.violation(5.0, solution.force);
    if (solution.residual < 1e-10) {
      EXPECT_LT(violation, 1e-8) << trial;
    }
    if (violation > 1e-8) {
      EXPECT_GT(solution.residual, 1e-9) << trial;
    }
  }
  RecordProperty("found", found);
  EXPECT_GT(found, 3 * problems / 4);
}

TEST(RootCone, RegularisedFrictionSatisfiesItsEquation) {
  std::mt19937 random(5);
  auto law = cone_law(0.5);
  law.friction_law = scene::FrictionLaw::regularised;
  law.friction_regularisation_s_m = 0.8;
  const double dt = 1e-3;
  for (int trial = 0; trial < 300; ++trial) {
    ConeProblem p(2 + trial % 8, 0.1, 1e-3, random);
    p.compliance *= 1e-6;
    if (p.gap_free.minCoeff() > 0.0) continue;
    test::UniformRoot root(law, p.compliance, p.areas(), dt);
    const auto& solution = root.solve(p.gap_free, p.slip_free, p.slip_velocity, root.open());
    EXPECT_LT(solution.residual, 1e-10) << trial;
    EXPECT_LE(solution.iterations, 30) << trial;
    const Eigen::VectorXd motion = p.compliance * solution.force;
    for (int i = 0; i < p.pairs(); ++i) {
      const Eigen::Vector2d slip = Eigen::Vector2d(p.slip_free[i], p.slip_free[p.pairs() + i]) + p.along(i, motion);
      const Eigen::Vector2d v = 2.0 / dt * slip - Eigen::Vector2d(p.slip_velocity[i], p.slip_velocity[p.pairs() + i]);
      const Eigen::Vector2d expected = -0.5 * solution.force[i] * std::tanh(0.8 * v.norm()) * v.normalized();
      EXPECT_LT((p.along(i, solution.force) - expected).norm(), 1e-9 * solution.force.maxCoeff()) << trial;
    }
  }
}

/// Pairs remember their springs: the slip of a window adds to the force of the last.
TEST(RootCone, PenaltySpringsRememberBothDirections) {
  auto law = cone_law(0.4);
  law.enforcement = scene::Enforcement::penalty;
  law.penalty_pa_m = 3.0;
  test::UniformRoot root(law, Eigen::MatrixXd(0.2 * Eigen::MatrixXd::Identity(3, 3)), {0.7}, 1e-3);
  const Eigen::VectorXd gap = Eigen::VectorXd::Constant(1, -1.0), still = Eigen::VectorXd::Zero(2);
  auto last = root.open();
  for (int window = 0; window < 2; ++window) {
    const Eigen::Vector2d slip_free(0.05, -0.1);
    const auto solution = root.solve(gap, slip_free, still, last);
    EXPECT_EQ(solution.states[0], ContactState::stick);
    for (int k = 0; k < 2; ++k)
      EXPECT_NEAR(solution.force[1 + k], last.force[1 + k] - 2.1 * (slip_free[k] + 0.2 * solution.force[1 + k]), 1e-14);
    last = solution;
  }
  const auto slipping = root.solve(gap, Eigen::Vector2d(3.0, -4.0), still, last);
  EXPECT_EQ(slipping.states[0], ContactState::slip);
  EXPECT_NEAR(slipping.force.tail<2>().norm(), 0.4 * slipping.force[0], 1e-14);
}

TEST(RootCone, ByProductsOrSparseSolvesWhatADenseComplianceSolves) {
  std::mt19937 random(12);
  for (const bool penalty : {false, true}) {
    for (const bool regularised : {false, true}) {
      for (int trial = 0; trial < 100; ++trial) {
        auto law = cone_law(0.3);
        if (penalty) law.enforcement = scene::Enforcement::penalty;
        law.penalty_pa_m = 2.0;
        if (regularised) law.friction_law = scene::FrictionLaw::regularised;
        law.friction_regularisation_s_m = 0.5;
        const int n = 1 + trial % 12;
        const ConeProblem shape(n, 0.01, 1.0, random);
        const Eigen::MatrixXd& dense = shape.compliance;
        const auto times = [&dense](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y.noalias() = dense * x; };
        test::UniformRoot root(law, dense, shape.areas(), 1.0),
            by_products(law, Compliance(times, dense.cwiseAbs().rowwise().sum()), shape.areas(), 1.0),
            sparse(law, Compliance::Sparse(dense.sparseView()), shape.areas(), 1.0);
        auto last = root.open();
        for (int window = 0; window < 3; ++window) {
          const ConeProblem p(n, 0.0, 1.0, random);
          const auto expected = root.solve(p.gap_free, p.slip_free, p.slip_velocity, last);
          for (auto* other : {&by_products, &sparse}) {
            const auto& found = other->solve(p.gap_free, p.slip_free, p.slip_velocity, last);
            EXPECT_LT((found.force - expected.force).norm(), 1e-9 * (1.0 + expected.force.norm())) << trial;
            EXPECT_EQ(found.states, expected.states) << trial;
            EXPECT_LT(found.residual, 1e-10);
          }
          last = expected;
        }
        const Eigen::VectorXd held = root.hold(shape.gap_free, shape.slip_free).force;
        for (auto* other : {&by_products, &sparse}) {
          EXPECT_LT((other->hold(shape.gap_free, shape.slip_free).force - held).norm(), 1e-9 * (1.0 + held.norm()));
        }
      }
    }
  }
}

TEST(RootCone, HoldsAllThreeDirections) {
  std::mt19937 random(5);
  const ConeProblem p(4, 1.0, 1.0, random);
  Eigen::VectorXd free(12);
  free << p.gap_free, p.slip_free;
  test::UniformRoot root(cone_law(0.3), p.compliance, p.areas(), 1e-3);
  EXPECT_LT((free + p.compliance * root.hold(p.gap_free, p.slip_free).force).norm(), 1e-12);
  auto law = cone_law(0.3);
  law.enforcement = scene::Enforcement::penalty;
  law.penalty_pa_m = 2.0;
  test::UniformRoot springs(law, p.compliance, p.areas(), 1e-3);
  const Eigen::VectorXd force = springs.hold(p.gap_free, p.slip_free).force;
  EXPECT_LT((force + 2.0 * (free + p.compliance * force)).norm(), 1e-11);
  EXPECT_LT((springs.spring(p.gap_free, p.slip_free).force + 2.0 * free).norm(), 1e-12);
}

/// Whichever two directions along the surface are called tangent and binormal.
TEST(RootCone, TurnsWithItsTangents) {
  std::mt19937 random(9);
  const double c = std::cos(0.7), s = std::sin(0.7);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + trial % 6;
    const ConeProblem p(n, 0.3, 1.0, random);
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(3 * n, 3 * n);
    for (int i = 0; i < n; ++i) {
      turn(n + i, n + i) = turn(2 * n + i, 2 * n + i) = c;
      turn(n + i, 2 * n + i) = s;
      turn(2 * n + i, n + i) = -s;
    }
    const Eigen::MatrixXd along = turn.bottomRightCorner(2 * n, 2 * n);
    for (const auto friction_law : {scene::FrictionLaw::return_mapping, scene::FrictionLaw::regularised}) {
      auto law = cone_law(0.4);
      law.friction_law = friction_law;
      test::UniformRoot root(law, p.compliance, p.areas(), 1.0),
          turned(law, Eigen::MatrixXd(turn * p.compliance * turn.transpose()), p.areas(), 1.0);
      const Eigen::VectorXd force = root.solve(p.gap_free, p.slip_free, p.slip_velocity, root.open()).force;
      const auto& found = turned.solve(p.gap_free, along * p.slip_free, along * p.slip_velocity, turned.open());
      EXPECT_LT((found.force - turn * force).norm(), 1e-9 * (1.0 + force.norm())) << trial;
    }
  }
}

/// Supports that hold a pair along the tangent: friction along the binormal alone.
TEST(RootCone, LeavesOutADirectionThatSupportsHold) {
  Eigen::MatrixXd compliance = 2.0 * Eigen::MatrixXd::Identity(3, 3);
  compliance(1, 1) = 0.0;
  test::UniformRoot root(cone_law(0.1), compliance, {1.0}, 1e-3);
  const auto& solution =
      root.solve(Eigen::VectorXd::Constant(1, -4.0), Eigen::Vector2d(0.0, 3.0), Eigen::VectorXd::Zero(2), root.open());
  EXPECT_EQ(solution.force[1], 0.0);
  EXPECT_NEAR(solution.force[2], -0.2, 1e-15);
  EXPECT_EQ(solution.states[0], ContactState::slip);
  EXPECT_LE(solution.iterations, 4);
}

}  // namespace
}  // namespace ricochet::solver
