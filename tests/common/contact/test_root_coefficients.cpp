#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/contact/root_problem.hpp"

// Contact problems whose pairs have coefficients of friction of their own, some of them none.

namespace ricochet::solver {
namespace {

struct Mixed {
  int pairs, along;  ///< tangential directions
  Eigen::MatrixXd compliance;
  Eigen::VectorXd gap_free, slip_free, slip_velocity;
  std::vector<RootProblem::PairLaw> laws;

  Mixed(int count, int directions, std::mt19937& random) : pairs(count), along(directions) {
    std::normal_distribution<double> normal;
    const auto draw = [&](int rows, int columns) {
      return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }).eval();
    };
    const int size = (1 + along) * pairs;
    const Eigen::MatrixXd a = draw(size, size);
    compliance = 0.02 * a * a.transpose() + Eigen::MatrixXd::Identity(size, size);
    gap_free = draw(pairs, 1);
    slip_free = draw(along * pairs, 1);
    slip_velocity = draw(along * pairs, 1);
    constexpr double coefficients[] = {0.0, 0.2, 1.5};
    for (int i = 0; i < pairs; ++i) laws.push_back({1.0, coefficients[i % 3]});
  }
  [[nodiscard]] Compliance products() const {
    const auto times = [this](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y.noalias() = compliance * x; };
    return {times, compliance.cwiseAbs().rowwise().sum()};
  }
  [[nodiscard]] Eigen::Vector2d tangential(int pair, const Eigen::VectorXd& x, int from) const {
    return {x[from + pair], along == 2 ? x[from + pairs + pair] : 0.0};
  }
};

/// Coulomb's law of each pair with its own coefficient, from the forces alone.
void expect_own_cones(const Mixed& p, const RootProblem::Solution& solution) {
  const Eigen::VectorXd moved = p.compliance * solution.force;
  const Eigen::VectorXd slip_of_all = p.slip_free + moved.tail(p.along * p.pairs);
  for (int i = 0; i < p.pairs; ++i) {
    const double limit = p.laws[static_cast<std::size_t>(i)].friction_coefficient * solution.force[i];
    const Eigen::Vector2d force = p.tangential(i, solution.force, p.pairs), slip = p.tangential(i, slip_of_all, 0);
    const ContactState state = solution.states[static_cast<std::size_t>(i)];
    if (limit == 0.0) {
      EXPECT_EQ(force.norm(), 0.0) << "no friction, or open";
      EXPECT_NE(state, ContactState::stick);
      continue;
    }
    EXPECT_LE(force.norm(), limit * (1.0 + 1e-9));
    if (state == ContactState::stick) {
      EXPECT_LT(slip.norm(), 1e-9);
    } else {
      EXPECT_NEAR(force.norm(), limit, 1e-9);
      EXPECT_LT((force + limit * slip.normalized()).norm(), 1e-7);
    }
  }
}

TEST(RootProblemOfSeveralCoefficients, HoldsEachPairWithinItsOwnCone) {
  std::mt19937 random(21);
  for (const int directions : {1, 2}) {
    int stuck = 0, slipped = 0;
    for (int trial = 0; trial < 60; ++trial) {
      const Mixed p(3 + trial % 7, directions, random);
      RootProblem root(scene::Contact{}, p.compliance, p.laws, 1e-3),
          by_products(scene::Contact{}, p.products(), p.laws, 1e-3);
      const auto& solution = root.solve(p.gap_free, p.slip_free, p.slip_velocity, root.open());
      expect_own_cones(p, solution);
      expect_own_cones(p, by_products.solve(p.gap_free, p.slip_free, p.slip_velocity, root.open()));
      for (const auto state : solution.states) {
        stuck += state == ContactState::stick;
        slipped += state == ContactState::slip;
      }
    }
    EXPECT_GT(stuck, 10);
    EXPECT_GT(slipped, 10);
  }
}

TEST(RootProblemOfSeveralCoefficients, RegularisesEachPairByItsOwn) {
  std::mt19937 random(22);
  scene::Contact law;
  law.friction_law = scene::FrictionLaw::regularised;
  law.friction_regularisation_s_m = 0.5;
  const double dt = 1.0;
  for (const int directions : {1, 2}) {
    for (int trial = 0; trial < 30; ++trial) {
      const Mixed p(3 + trial % 7, directions, random);
      RootProblem root(law, p.compliance, p.laws, dt);
      const auto& solution = root.solve(p.gap_free, p.slip_free, p.slip_velocity, root.open());
      const Eigen::VectorXd moved = p.compliance * solution.force;
      const Eigen::VectorXd velocity = 2.0 / dt * (p.slip_free + moved.tail(p.along * p.pairs)) - p.slip_velocity;
      for (int i = 0; i < p.pairs; ++i) {
        const Eigen::Vector2d v = p.tangential(i, velocity, 0), force = p.tangential(i, solution.force, p.pairs);
        const double limit = p.laws[static_cast<std::size_t>(i)].friction_coefficient * solution.force[i];
        EXPECT_LT((force + limit * std::tanh(0.5 * v.norm()) * v.normalized()).norm(), 1e-8) << trial;
      }
    }
  }
}

/// While the stability of a scheme is measured, pairs without friction are held along the normal alone.
TEST(RootProblemOfSeveralCoefficients, HoldsPairsWithFrictionAloneAlongTheSurface) {
  std::mt19937 random(23);
  for (const int directions : {1, 2}) {
    const Mixed p(6, directions, random);
    RootProblem root(scene::Contact{}, p.compliance, p.laws, 1e-3);
    const Eigen::VectorXd force = root.hold(p.gap_free, p.slip_free).force;
    const Eigen::VectorXd moved = p.compliance * force, slip = p.slip_free + moved.tail(p.along * p.pairs);
    for (int i = 0; i < p.pairs; ++i) {
      EXPECT_NEAR(p.gap_free[i] + moved[i], 0.0, 1e-10);
      const bool friction = p.laws[static_cast<std::size_t>(i)].friction_coefficient > 0.0;
      EXPECT_NEAR((friction ? p.tangential(i, slip, 0) : p.tangential(i, force, p.pairs)).norm(), 0.0, 1e-10);
    }
  }
}

}  // namespace
}  // namespace ricochet::solver
