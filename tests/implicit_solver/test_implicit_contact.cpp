#include <gtest/gtest.h>

#include "tests/support/contact_trial.hpp"

// The contact of the implicit side on one row that is no node pair.

namespace ricochet::implicit_solver {
namespace {

using test::Trial;
constexpr double dt = Trial::dt;

/// Plates that meet at (1, rate_n) m/s on one row.
test::ContactPlates meeting(const std::string& keys = "", double rate_n = 4.0) {
  test::ContactPlates plates("all_implicit", keys);
  plates.use_one_row();
  plates.set_velocity(0, {0.5, 0.75 * rate_n});
  plates.set_velocity(1, {-0.5, -0.25 * rate_n});
  return plates;
}

TEST(ImplicitContact, ClosesTheGapOfAnyRowAndLeavesNoRelativeVelocityAndKeepsMomentum) {
  Trial trial(meeting());
  const Eigen::Vector2d before = trial.momentum();
  trial.solve();
  EXPECT_EQ(trial.contact->root_dofs().size(), 3U) << "the row's three nodes along n";
  EXPECT_NEAR(trial.gap(), 0.0, 1e-20);
  const auto& normal = trial.plates.surface.pairs[0].normal;
  EXPECT_NEAR(trial.along(normal, trial.velocity), 0.0, 1e-14);
  EXPECT_NEAR(trial.along(normal, trial.acceleration), 0.0, 1e-7) << "of accelerations of 1e7 m/s^2";
  EXPECT_LT((trial.momentum() - before).norm(), 1e-13 * before.norm());
}

TEST(ImplicitContact, LeavesASeparatingRowAlone) {
  Trial trial(meeting("", -4.0));
  const Eigen::VectorXd before = trial.velocity;
  trial.solve();
  EXPECT_EQ(trial.contact->root_force().norm(), 0.0);
  EXPECT_EQ(trial.velocity, before);
}

// 1 m/s along t against 4 m/s along n: the impulse that holds it lies inside the cone from mu = 1/4 on.
TEST(ImplicitContact, HoldsOrSlipsByTheConeOfTheRow) {
  for (const auto& [mu, rate_after] : {std::pair{"0.2", 0.2}, std::pair{"0.3", 0.0}}) {
    Trial trial(meeting(std::string("friction_coefficient = ") + mu + "\n"));
    const Eigen::Vector2d before = trial.momentum();
    trial.solve();
    const auto& tangent = trial.plates.surface.pairs[0].tangent;
    EXPECT_NEAR(std::abs(trial.along(tangent, trial.velocity)), rate_after, 1e-13) << mu;
    EXPECT_LT((trial.momentum() - before).norm(), 1e-13 * before.norm()) << mu;
  }
}

TEST(ImplicitContact, ReportsTheImpulseOfTheWindowAsItsForce) {
  Trial trial(meeting());
  trial.solve();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(trial.mass.size());
  trial.contact->account(trial.plates.states, trial.increment, zero);
  trial.contact->accept();
  // p = 4 m/s / (N M^-1 N^T)
  const double impulse = 4.0 / trial.plates.surface.pairs[0].normal.inverse_mass(trial.plates.states);
  const auto report = trial.contact->report(trial.plates.states);
  EXPECT_NEAR(report.contact_force_n, impulse / dt, 1e-12 * impulse / dt);
  EXPECT_NEAR(report.contact_impulse_n_s, impulse, 1e-12 * impulse);
  EXPECT_EQ(report.pairs_stick + report.pairs_slip, 1);
}

}  // namespace
}  // namespace ricochet::implicit_solver
