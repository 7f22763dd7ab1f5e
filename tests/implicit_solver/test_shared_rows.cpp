#include <gtest/gtest.h>

#include "tests/support/contact_trial.hpp"

// The contact of the implicit side on pairs that share nodes.

namespace ricochet::implicit_solver {
namespace {

using test::Trial;

/// Lower nodes at 3 m/s and twice and half of that, so that the rows want forces of different size.
test::ContactPlates uneven(const std::string& keys = "") {
  test::ContactPlates plates("all_implicit", keys);
  plates.set_velocity(0, {0.5, 3.0});
  plates.set_velocity(1, {-0.5, -1.0});
  plates.states[0].v[2 * plates.node_at(0, {0.0, 0.0}) + 1] = 6.0;
  plates.states[0].v[2 * plates.node_at(0, {0.2, 0.0}) + 1] = 1.5;
  return plates;
}

void finish(Trial& trial) {
  trial.contact->account(trial.plates.states, trial.increment, Eigen::VectorXd::Zero(trial.mass.size()));
  trial.contact->accept();
}

TEST(SharedRows, CloseTheirGapsAndLeaveNoRelativeVelocityAndKeepMomentum) {
  auto plates = uneven();
  plates.use_three_rows();
  Trial trial(plates);
  const Eigen::Vector2d before = trial.momentum();
  trial.solve();
  EXPECT_EQ(trial.contact->root_dofs().size(), 6U) << "three nodes a side, along n";
  for (const auto& pair : trial.plates.surface.pairs) {
    EXPECT_NEAR(trial.along(pair.normal, trial.increment), 0.0, 1e-18);
    EXPECT_NEAR(trial.along(pair.normal, trial.velocity), 0.0, 1e-11);
    EXPECT_NEAR(trial.along(pair.normal, trial.acceleration), 0.0, 1e-4) << "of accelerations of 1e7 m/s^2";
  }
  EXPECT_LT((trial.momentum() - before).norm(), 1e-13 * before.norm());
}

/// The impulse that is told is what each of the bodies got, and its work what their kinetic energy lost: no strain in a
/// window whose operator is M alone.
TEST(SharedRows, TellTheImpulseAndTheWorkThatTheBodiesGot) {
  for (const char* friction : {"", "friction_coefficient = 0.1\n", "friction_coefficient = 0.9\n"}) {
    auto plates = uneven(friction);
    plates.use_three_rows();
    Trial trial(plates);
    const Eigen::VectorXd before = trial.velocity;
    const auto lower = trial.plates.states[0].part.dofs();
    trial.solve();
    finish(trial);
    const auto report = trial.contact->report(trial.plates.states);
    Eigen::Vector2d gained(0.0, 0.0);
    for (int dof = 0; dof < lower; ++dof) gained[dof % 2] += trial.mass[dof] * (trial.velocity[dof] - before[dof]);
    EXPECT_NEAR(report.contact_impulse_n_s, -gained[1], 1e-12 * std::abs(gained[1])) << friction;
    EXPECT_NEAR(report.friction_impulse_n_s, gained[0], 1e-12 * std::abs(gained[1])) << friction;
    EXPECT_NEAR(report.contact_force_n * Trial::dt, report.contact_impulse_n_s, 1e-12 * std::abs(gained[1]));
    EXPECT_LE(report.contact_residual, 1e-12) << friction;
  }
}

/// Coulomb's law by impulses, pair by pair: 0.1 slips, 0.9 holds.
TEST(SharedRows, HoldOrSlipByTheirCones) {
  for (const double mu : {0.1, 0.9}) {
    auto plates = uneven("friction_coefficient = " + std::to_string(mu) + "\n");
    plates.use_three_rows();
    Trial trial(plates);
    trial.solve();
    trial.contact->accept();
    const auto state = trial.contact->state();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& impulse = state.mean_forces[i];
      const double rate = trial.along(trial.plates.surface.pairs[i].tangent, trial.velocity);
      EXPECT_LE(std::abs(impulse.tangential[0]), mu * impulse.normal * (1.0 + 1e-12));
      if (impulse.state == solver::ContactState::slip) {
        EXPECT_NEAR(std::abs(impulse.tangential[0]), mu * impulse.normal, 1e-12 * impulse.normal);
        EXPECT_LE(impulse.tangential[0] * rate, 0.0) << "against the slip";
      } else {
        EXPECT_NEAR(rate, 0.0, 1e-11);
      }
    }
    EXPECT_EQ(state.mean_forces[1].state, mu > 0.5 ? solver::ContactState::stick : solver::ContactState::slip);
  }
}

}  // namespace
}  // namespace ricochet::implicit_solver
