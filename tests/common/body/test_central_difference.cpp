#include <gtest/gtest.h>

#include "common/body/central_difference.hpp"
#include "tests/support/rods.hpp"

namespace ricochet::solver {
namespace {

// 1 kg on a spring of 8 N/m at u = 0.5 m and v = 1 m/s: a = -4, u' = 0.5 + 0.1 - 0.02 = 0.58, a' = -4.64,
// v' = 1 - 0.05 * 8.64.
TEST(CentralDifference, StepsOneMassOnASpringAsByHand) {
  test::SceneStates scene(test::rod(1,
                                    "support = [{ surface = \"start\", fixed = [\"x\"] }]\n"
                                    "initial_displacement_m = { start = [0.0], end = [0.5] }\n"
                                    "initial_velocity_m_s = [1.0]"));
  const auto& rod = scene.states.at(0);
  const double dt = 0.1;
  Eigen::VectorXd internal(2), next;
  const auto acceleration = [&](const Eigen::VectorXd& u) -> Eigen::VectorXd {
    rod.stiffness.multiply(u, internal);
    return -rod.inverse_mass.cwiseProduct(internal);
  };
  const Eigen::VectorXd a = acceleration(rod.u);
  step_displacement(rod, dt, dt, rod.u, rod.v, a, next);
  const Eigen::VectorXd a_next = acceleration(next);
  const Eigen::VectorXd v_next = fem::corrected_velocity(rod.v, a, a_next, dt);
  EXPECT_EQ(next[0], 0.0);
  EXPECT_NEAR(next[1], 0.58, 1e-15);
  EXPECT_NEAR(a_next[1], -4.64, 1e-14);
  EXPECT_NEAR(v_next[1], 0.568, 1e-15);
}

/// A rod whose start is moved to 0.25, 0.5 and 1.25 m at t = 0.5, 1 and 1.5 s.
const std::string driven = test::rod(
    1,
    "prescribed = [{ surface = \"start\", component = \"x\", displacement_m = 0.5, amplitude = { time_s = [0.0, 1.0, "
    "2.0], factor = [0.0, 1.0, 4.0] } }]");

TEST(CentralDifference, MovesAPrescribedNodeWhereItIsAtTheEndOfTheStep) {
  const test::SceneStates scene(driven);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(2), one = Eigen::VectorXd::Ones(2);
  Eigen::VectorXd next;
  step_displacement(scene.states.at(0), 1.5, 0.5, zero, one, zero, next);
  EXPECT_EQ(next[0], 1.25);
  EXPECT_EQ(next[1], 0.5);
}

// These three places are an acceleration of 2 m/s^2 of 1 kg; K u = 8 (0.5 - 0.2) N.
TEST(CentralDifference, ReactionIsMassTimesAccelerationAndTheElementsForce) {
  const test::SceneStates scene(driven);
  const auto& rod = scene.states.at(0);
  Eigen::VectorXd internal(2), external = Eigen::VectorXd::Zero(2);
  rod.stiffness.multiply(Eigen::Vector2d(0.5, 0.2), internal);
  set_reactions(rod, 1.0, 0.5, internal, external);
  EXPECT_NEAR(external[0], 2.0 + 2.4, 1e-14);
  EXPECT_EQ(external[1], 0.0) << "nothing holds the other end";
}

// rho c A = 4 kg/s and v_0 = 0.25 m/s. With v_{n+1/2} = 1 m/s, others of 5 N, dt = 0.5 s and 1 kg:
// a = (5 - 4 * 0.75) / (1 + 0.25 * 4) = 1, v_{n+1} = 1.25 and the dashpot's force -4 N, whose sum with 5 N is m a.
TEST(CentralDifference, DashpotsJoinTheLoadsAndReplaceTheirForceOfTheStepBefore) {
  for (const bool loaded : {false, true}) {
    const std::string keys = "absorbing = [{ surface = \"start\" }]\ninitial_velocity_m_s = [0.25]";
    const test::SceneStates scene(test::rod(1, loaded ? keys + "\ngravity_m_s2 = [2.0]" : keys));
    const auto& rod = scene.states.at(0);
    ASSERT_EQ(rod.dashpots.size(), 1U);
    Eigen::VectorXd external = Eigen::VectorXd::Constant(2, -7.0);  // of the step before
    if (loaded) rod.external.at(0.0, external);
    const double load = loaded ? 2.0 : 0.0;
    add_dashpot_forces(
        rod, 0.5, [](int) { return 1.0; }, [&](int, double of_load) { return 5.0 - load + of_load; }, external);
    EXPECT_NEAR(external[0], load - 4.0, 1e-14);
  }
}

}  // namespace
}  // namespace ricochet::solver
