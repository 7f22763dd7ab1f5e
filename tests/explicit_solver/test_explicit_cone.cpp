#include <gtest/gtest.h>

#include "explicit_solver/explicit_contact.hpp"
#include "tests/support/contact_blocks.hpp"

// Friction of solids in all-explicit: what each pair gets follows from its own rows, or from all where they share
// nodes.

namespace ricochet::explicit_solver {
namespace {

constexpr double cone_dt = 1e-6;
const WindowClock cone_clock = cone_dt;

test::ContactBlocks meeting_blocks(const std::string& keys, const std::string& body_keys = "") {
  test::ContactBlocks blocks("all_explicit", keys, body_keys);
  blocks.set_velocity({0.6, 0.8, 4.0}, {1.0, -3.0, 2.0});
  return blocks;
}

auto acceleration_in(const std::vector<solver::BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].a; };
}

/// Relative velocity along the surface half a window later, which the force of the start is to make zero.
Eigen::Vector2d slip_rate(const test::ContactBlocks& blocks, std::size_t pair) {
  const auto& p = blocks.surface.pairs[pair];
  return p.slip(velocity_of(blocks.states)) + 0.5 * cone_dt * p.slip(acceleration_in(blocks.states));
}

void expect_coulomb(const test::ContactBlocks& blocks, const ExplicitContact& contact, double mu, double tolerance) {
  const auto forces = contact.state().forces;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const double normal = forces[i].normal, length = forces[i].tangential.norm();
    ASSERT_GT(normal, 0.0);
    EXPECT_LE(length, mu * normal * (1.0 + tolerance));
    const Eigen::Vector2d rate = slip_rate(blocks, i);
    if (forces[i].state == solver::ContactState::stick) {
      EXPECT_LT(rate.norm(), 1e-10);
    } else {
      EXPECT_NEAR(length, mu * normal, tolerance * mu * normal);
      EXPECT_NEAR(forces[i].tangential.dot(rate), -length * rate.norm(), tolerance * length * rate.norm())
          << "straight against the slip";
    }
  }
}

TEST(ExplicitCone, ClipsTheForceThatHoldsRadially) {
  for (const auto& [mu, sticking] : {std::pair{0.1, 0}, std::pair{0.3, 4}, std::pair{0.7, 9}}) {
    auto blocks = meeting_blocks("friction_coefficient = " + std::to_string(mu) + "\n");
    const auto before = blocks;
    ExplicitContact contact(blocks.problem.scene.contact_law(), blocks.surface, cone_clock);
    contact.start(blocks.states);
    expect_coulomb(blocks, contact, mu, 1e-12);
    int sticks = 0;
    for (std::size_t i = 0; i < 9; ++i) {
      const auto force = contact.state().forces[i];
      const Eigen::Vector2d rate = before.surface.pairs[i].slip(velocity_of(before.states));
      const double inverse = before.surface.pairs[i].tangent.inverse_mass(before.states);
      const Eigen::Vector2d holding = -rate / (0.5 * cone_dt * inverse);
      const Eigen::Vector2d expected = holding * std::min(1.0, mu * force.normal / holding.norm());
      EXPECT_LT((force.tangential - expected).norm(), 1e-12 * force.normal) << i;
      sticks += force.state == solver::ContactState::stick;
    }
    EXPECT_EQ(sticks, sticking) << mu;
  }
}

TEST(ExplicitCone, HoldsForPairsThatShareNodes) {
  for (const double mu : {0.05, 0.2, 0.9}) {
    auto blocks = meeting_blocks("friction_coefficient = " + std::to_string(mu) + "\n");
    blocks.share_nodes();
    ExplicitContact contact(blocks.problem.scene.contact_law(), blocks.surface, cone_clock);
    contact.start(blocks.states);
    expect_coulomb(blocks, contact, mu, 1e-9);
    const auto report = contact.report(blocks.states);
    EXPECT_GT(report.contact_iterations, 2);
    EXPECT_LE(report.contact_residual, 1e-12);
  }
}

// Held along x by supports, the pairs slip along y alone: what would hold them along x is the supports' affair.
TEST(ExplicitCone, CountsOnlyDirectionsInWhichThePairIsFree) {
  auto blocks =
      meeting_blocks("friction_coefficient = 0.1\n",
                     "support = [{ surface = \"start\", fixed = [\"x\"] }, { surface = \"end\", fixed = [\"x\"] }]\n");
  blocks.set_velocity({0.0, 0.8, 4.0}, {0.0, 0.0, 0.0});
  ExplicitContact contact(blocks.problem.scene.contact_law(), blocks.surface, cone_clock);
  contact.start(blocks.states);
  const auto state = contact.state();
  for (const auto& force : state.forces) {
    EXPECT_EQ(force.tangential[0], 0.0);
    EXPECT_NEAR(std::abs(force.tangential[1]), 0.1 * force.normal, 1e-12 * force.normal);
  }
}

TEST(ExplicitCone, RegularisedTakesTheVelocityThatItLeaves) {
  auto blocks = meeting_blocks("friction_coefficient = 0.3\nfriction_law = \"regularised\"\n");
  ExplicitContact contact(blocks.problem.scene.contact_law(), blocks.surface, cone_clock);
  contact.start(blocks.states);
  for (std::size_t i = 0; i < 9; ++i) {
    const auto force = contact.state().forces[i];
    const Eigen::Vector2d rate = slip_rate(blocks, i);
    const Eigen::Vector2d expected = -0.3 * force.normal * std::tanh(rate.norm()) * rate.normalized();
    EXPECT_LT((force.tangential - expected).norm(), 1e-11 * force.normal) << i;
  }
}

}  // namespace
}  // namespace ricochet::explicit_solver
