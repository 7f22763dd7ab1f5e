#include <gtest/gtest.h>

#include "tests/support/contact_blocks.hpp"
#include "tests/support/contact_trial.hpp"

// Friction of solids on the implicit side, held by impulses on the circular cone.

namespace ricochet::implicit_solver {
namespace {

using BlockTrial = test::TrialOf<test::ContactBlocks>;

test::ContactBlocks meeting_blocks(const std::string& keys) {
  test::ContactBlocks blocks("all_implicit", keys);
  blocks.set_velocity({0.6, 0.8, 4.0}, {1.0, -3.0, 2.0});
  return blocks;
}

Eigen::Vector2d slip_rate(const BlockTrial& trial, std::size_t pair) {
  const auto& p = trial.plates.surface.pairs[pair];
  return {trial.along(p.tangent, trial.velocity), trial.along(p.binormal, trial.velocity)};
}

void expect_coulomb(const BlockTrial& trial, double mu, double tolerance, const std::string& keys) {
  const auto state = trial.contact->state();
  for (std::size_t i = 0; i < state.mean_forces.size(); ++i) {
    const auto& impulse = state.mean_forces[i];
    const double length = impulse.tangential.norm();
    ASSERT_GT(impulse.normal, 0.0);
    EXPECT_LE(length, mu * impulse.normal * (1.0 + tolerance)) << keys;
    const Eigen::Vector2d rate = slip_rate(trial, i);
    if (impulse.state == solver::ContactState::stick) {
      EXPECT_LT(rate.norm(), 1e-10) << keys;
    } else {
      EXPECT_NEAR(length, mu * impulse.normal, tolerance * mu * impulse.normal) << keys;
      EXPECT_NEAR(impulse.tangential.dot(rate), -length * rate.norm(), 10.0 * tolerance * length * rate.norm()) << keys;
    }
  }
}

TEST(ImplicitCone, HoldsOrSlipsByTheImpulseOfEachPair) {
  for (const char* law : {"", "enforcement = \"penalty\"\npenalty_pa_m = 1e14\nimpact_update = \"mass\"\n"}) {
    for (const auto& [mu, state] :
         {std::pair{0.1, solver::ContactState::slip}, std::pair{0.7, solver::ContactState::stick}}) {
      BlockTrial trial(meeting_blocks("friction_coefficient = " + std::to_string(mu) + "\n" + law));
      const Eigen::VectorXd before = trial.momentum();
      trial.solve();
      trial.contact->accept();
      expect_coulomb(trial, mu, 1e-12, law);
      const auto told = trial.contact->state();
      for (const auto& impulse : told.mean_forces) EXPECT_EQ(impulse.state, state) << law << mu;
      EXPECT_LT((trial.momentum() - before).norm(), 1e-13 * before.norm()) << law;
    }
  }
}

/// Forces move nodes near them, too: half as far an edge away.
TEST(ImplicitCone, HasTheForcesOfADenseInverseWithoutASolveAWindow) {
  for (const bool shared : {false, true}) {
    auto blocks = meeting_blocks("friction_coefficient = 0.3\n");
    if (shared) blocks.share_nodes();
    BlockTrial dense(blocks), near(blocks);
    const auto& root = dense.contact->root_dofs();
    const auto size = static_cast<Eigen::Index>(root.size());
    const int second = blocks.states[0].part.dofs();
    const double edge_m = std::sqrt(blocks.surface.pairs[4].area_m2);
    const auto position = [&](int dof) {
      const auto& part = blocks.states[dof < second ? 0 : 1].part;
      return part.mesh.position[static_cast<std::size_t>((dof % second) / 3)];
    };
    const auto entry = [&](Eigen::Index i, Eigen::Index j) {
      const int a = root[static_cast<std::size_t>(i)], b = root[static_cast<std::size_t>(j)];
      if ((a < second) != (b < second) || a % 3 != b % 3) return 0.0;
      const double edges_apart = (position(a) - position(b)).norm() / edge_m;
      return std::pow(0.5, edges_apart) / std::sqrt(dense.mass[a] * dense.mass[b]);
    };
    const Eigen::MatrixXd inverse = Eigen::MatrixXd::NullaryExpr(size, size, entry);
    int solves = 0;
    dense.contact->prepare(inverse, BlockTrial::dt);
    near.contact->prepare(
        blocks.states,
        [&](const Eigen::VectorXd& forces, Eigen::VectorXd& motion) {
          ++solves;
          motion = inverse * forces;
        },
        BlockTrial::dt);
    const int at_start = solves;
    EXPECT_GT(at_start, 0);
    dense.contact->solve(blocks.states, dense.increment, false);
    near.contact->solve(blocks.states, near.increment, false);
    const auto& expected = dense.contact->root_force();
    EXPECT_GT(expected.norm(), 0.0);
    EXPECT_LT((near.contact->root_force() - expected).norm(), 1e-10 * expected.norm()) << shared;
    EXPECT_EQ(solves, at_start);
  }
}

TEST(ImplicitCone, HoldsForPairsThatShareNodes) {
  for (const double mu : {0.1, 0.2, 0.6}) {
    auto blocks = meeting_blocks("friction_coefficient = " + std::to_string(mu) + "\n");
    blocks.share_nodes();
    BlockTrial trial(blocks);
    trial.solve();
    trial.contact->accept();
    expect_coulomb(trial, mu, 1e-9, "shared");
  }
}

TEST(ImplicitCone, RegularisedTakesTheVelocityThatItLeaves) {
  BlockTrial trial(meeting_blocks("friction_coefficient = 0.3\nfriction_law = \"regularised\"\n"));
  trial.solve();
  trial.contact->accept();
  for (std::size_t i = 0; i < 9; ++i) {
    const auto impulse = trial.contact->state().mean_forces[i];
    const Eigen::Vector2d rate = slip_rate(trial, i);
    const Eigen::Vector2d expected = -0.3 * impulse.normal * std::tanh(rate.norm()) * rate.normalized();
    EXPECT_LT((impulse.tangential - expected).norm(), 1e-11 * impulse.normal) << i;
  }
}

/// The impulses that are told are what each of the bodies got, and their work what the kinetic energy lost: no strain
/// in a window whose operator is M alone.
TEST(ImplicitCone, TellsTheImpulseAndTheWorkThatTheBodiesGot) {
  for (const bool shared : {false, true}) {
    auto blocks = meeting_blocks("friction_coefficient = 0.2\n");
    if (shared) blocks.share_nodes();
    BlockTrial trial(blocks);
    const Eigen::VectorXd before = trial.velocity;
    const auto lower = trial.plates.states[0].part.dofs();
    trial.solve();
    const Eigen::VectorXd before_the_jump = before + 0.5 * BlockTrial::dt * trial.force.cwiseQuotient(trial.mass);
    const Eigen::VectorXd middle = 0.5 * (before_the_jump + trial.velocity);
    trial.contact->account(trial.plates.states, trial.increment, middle);
    trial.contact->accept();
    const auto report = trial.contact->report(trial.plates.states);
    Eigen::Vector3d gained(0.0, 0.0, 0.0);
    for (int dof = 0; dof < lower; ++dof) gained[dof % 3] += trial.mass[dof] * (trial.velocity[dof] - before[dof]);
    const double scale = std::abs(gained[2]);
    EXPECT_NEAR(report.contact_impulse_n_s, -gained[2], 1e-12 * scale);
    EXPECT_NEAR(report.friction_impulse_n_s, -gained[0], 1e-12 * scale);
    EXPECT_NEAR(report.friction_impulse_b_n_s, -gained[1], 1e-12 * scale);
    const double kinetic =
        0.5 * (trial.mass.array() * (trial.velocity.array().square() - before.array().square())).sum();
    EXPECT_NEAR(report.energy_contact_j - report.energy_friction_j, kinetic, 1e-10 * std::abs(kinetic)) << shared;
    EXPECT_GT(report.energy_friction_j, 0.01 * std::abs(kinetic));
  }
}

}  // namespace
}  // namespace ricochet::implicit_solver
