#include <gmock/gmock.h>

#include <limits>

#include "common/base/error.hpp"
#include "common/body/body_state.hpp"
#include "common/solver/describe.hpp"
#include "tests/support/blocks.hpp"
#include "tests/support/plates.hpp"
#include "tests/support/rods.hpp"

namespace ricochet::solver {
namespace {

using testing::ElementsAre;

const std::string held_at_start = "support = [{ surface = \"start\", fixed = [\"x\"] }]";

std::vector<double> list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

TEST(Dashpot, IsAfterAStepTheForceAtTheVelocityThatItGives) {
  const Dashpot dashpot{0, 3.0, 0.5};
  const double mass = 2.0, dt = 0.1, half_velocity = 1.5, others = 4.0;
  const double force = dashpot.force_after_step(half_velocity, others, mass, dt);
  const double velocity = half_velocity + 0.5 * dt * (others + force) / mass;
  EXPECT_NEAR(force, -3.0 * (velocity - 0.5), 1e-15);
  EXPECT_NEAR(velocity, 1.5 + 0.05 / 2.15, 1e-15) << "a = (4 - 3 (1.5 - 0.5)) / (2 + 3 * 0.1 / 2)";
}

TEST(Dashpot, DoesNotBrakeABodyInFlight) {
  const Dashpot dashpot{0, 3.0, 0.5};
  EXPECT_EQ(dashpot.force(0.5), 0.0);
  EXPECT_EQ(dashpot.force_after_step(0.5, 0.0, 2.0, 0.1), 0.0);
}

// Amplitudes 0.5, 1 and 2.5 half a second before, at and after t = 1 s, times 2 mm.
TEST(ConstrainedDof, HasTheCentralDifferencesOfItsMotionAsRates) {
  const scene::Amplitude amplitude{{0.0, 1.0, 2.0}, {0.0, 1.0, 4.0}};
  const ConstrainedDof moved{0, 2e-3, &amplitude};
  EXPECT_NEAR(moved.at(1.5), 5e-3, 1e-18);
  EXPECT_NEAR(moved.velocity(1.0, 0.5), 4e-3, 1e-17);
  EXPECT_NEAR(moved.acceleration(1.0, 0.5), 8e-3, 1e-17);
  const ConstrainedDof fixed{0, 2e-3, nullptr};
  EXPECT_EQ(fixed.at(7.0), 2e-3);
  EXPECT_EQ(fixed.velocity(1.0, 0.5), 0.0);
  EXPECT_EQ(fixed.acceleration(1.0, 0.5), 0.0);
}

TEST(BodyState, BeginsAsTheSceneSaysAndKeepsOnlyWhatIsHeldInPlace) {
  test::SceneStates scene(test::rod(2, held_at_start + "\ninitial_velocity_m_s = [3.0]\n"
                                                       "initial_displacement_m = { start = [0.0], end = [0.75] }"));
  auto& rod = scene.states.at(0);
  EXPECT_THAT(list(rod.u), ElementsAre(0.0, 0.375, 0.75));
  EXPECT_THAT(list(rod.v), ElementsAre(0.0, 3.0, 3.0));
  Eigen::VectorXd u = Eigen::VectorXd::Ones(3), v = u, a = u;
  rod.constrain_displacement(1.0, u);
  rod.constrain_velocity(1.0, 0.1, v);
  rod.constrain_acceleration(1.0, 0.1, a);
  EXPECT_THAT(list(u), ElementsAre(0.0, 1.0, 1.0));
  EXPECT_THAT(list(v), ElementsAre(0.0, 1.0, 1.0));
  EXPECT_THAT(list(a), ElementsAre(0.0, 1.0, 1.0));
}

TEST(BodyState, HasTheMassButNotTheInverseOfItWhereItIsHeld) {
  const test::SceneStates scene(test::rod(2, held_at_start));
  const auto& rod = scene.states.at(0);
  EXPECT_THAT(list(rod.mass), ElementsAre(1.0, 2.0, 1.0));
  EXPECT_THAT(list(rod.inverse_mass), ElementsAre(0.0, 0.5, 1.0));
  EXPECT_THAT(rod.free, ElementsAre(false, true, true));
  EXPECT_EQ(rod.totals.mass_kg, 4.0) << "of both elements";
}

TEST(BodyState, CountsTheMassOfANodeOnceInTwoDimensions) {
  const test::Plates plates("all_implicit");
  EXPECT_NEAR(plates.states[0].totals.mass_kg, 40.0, 1e-12) << "0.2 m x 0.2 m x 1 m of 1000 kg/m^3";
  EXPECT_NEAR(plates.states[1].totals.mass_kg, 80.0, 1e-12);
}

// The node that two participants share has 1 kg of an element of each.
TEST(BodyState, OfAllParticipantsTogetherHasTheMassOfTheBody) {
  test::SceneStates outside(test::two_rods("hughes_liu"), "explicit"), inside(test::two_rods("hughes_liu"), "implicit");
  take_interface_mass({2.0, 2.0}, outside.states);
  take_interface_mass({2.0, 2.0}, inside.states);
  EXPECT_THAT(list(outside.states[0].mass), ElementsAre(1.0, 2.0, 2.0, 0.0));
  EXPECT_THAT(list(inside.states[0].mass), ElementsAre(2.0, 1.0));
  EXPECT_EQ(outside.states[0].totals.mass_kg + inside.states[0].totals.mass_kg, 8.0);
}

// A turn by 2 rad/s about the origin, v = 2 (-y, x), of a plate of 80 kg. A quarter, a half and a quarter of it are
// lumped at x = 0, 0.1 and 0.2 m and at y = 0, 0.2 and 0.4 m: mean x 0.1 m, y 0.2 m, x^2 0.015 m^2, y^2 0.06 m^2.
TEST(BodyState, SumsMomentumAndAngularMomentumOfATurningPlate) {
  test::Plates plates("all_implicit");
  auto& plate = plates.states[1];
  for (int node = 0; node < plate.part.nodes(); ++node) {
    const auto& x = plate.part.mesh.position[static_cast<std::size_t>(node)];
    plate.v.segment<2>(2 * node) << -2.0 * x[1], 2.0 * x[0];
  }
  plate.update_momentum();
  EXPECT_NEAR(plate.totals.momentum_n_kg_m_s, 80.0 * 2.0 * 0.1, 1e-12) << "n = (0, 1)";
  EXPECT_NEAR(plate.totals.momentum_t_kg_m_s, 80.0 * 2.0 * 0.2, 1e-12) << "t = (-1, 0)";
  EXPECT_NEAR(plate.totals.angular_momentum_z_kg_m2_s, 80.0 * 2.0 * (0.015 + 0.06), 1e-12);
  EXPECT_EQ(plate.totals.angular_momentum_x_kg_m2_s, 0.0);
  // Displaced by d all of it is by d x p more, where a momentum p is.
  for (int node = 0; node < plate.part.nodes(); ++node) plate.u.segment<2>(2 * node) << 0.5, -0.25;
  plate.update_momentum();
  EXPECT_NEAR(plate.totals.angular_momentum_z_kg_m2_s,
              80.0 * 2.0 * (0.015 + 0.06) + 80.0 * 2.0 * (0.5 * 0.1 - 0.25 * 0.2), 1e-12);
}

/// A turn w about the origin, v = w x r, of a block displaced by d: L = sum m r x (w x r), r = x + d, added up here
/// from the mean places and the squares of a block that is lumped at 3 x 3 x 3 nodes.
TEST(BodyState, SumsTheAngularMomentumOfATurningBlock) {
  test::Blocks blocks("all_implicit");
  auto& block = blocks.states[0];
  const Eigen::Vector3d turn(1.0, -2.0, 3.0), moved(0.5, 0.25, -0.125);
  Eigen::Vector3d expected = Eigen::Vector3d::Zero();
  for (int node = 0; node < block.part.nodes(); ++node) {
    const Eigen::Vector3d at = block.part.mesh.position[static_cast<std::size_t>(node)] + moved;
    block.u.segment<3>(3 * node) = moved;
    block.v.segment<3>(3 * node) = turn.cross(at);
    expected += block.mass[3 * node] * (at.squaredNorm() * turn - at.dot(turn) * at);
  }
  block.update_momentum();
  const Eigen::Vector3d found(block.totals.angular_momentum_x_kg_m2_s, block.totals.angular_momentum_y_kg_m2_s,
                              block.totals.angular_momentum_z_kg_m2_s);
  EXPECT_LT((found - expected).norm(), 1e-13 * expected.norm());
  block.give_moment(1, 2.0, [&](int dof) { return block.u[dof]; });  // along y, at the place of the first node
  const Eigen::Vector3d at = block.part.mesh.position[0] + moved;
  EXPECT_NEAR(block.totals.angular_impulse_x_kg_m2_s, -2.0 * at[2], 1e-15);
  EXPECT_EQ(block.totals.angular_impulse_y_kg_m2_s, 0.0);
  EXPECT_NEAR(block.totals.angular_impulse_z_kg_m2_s, 2.0 * at[0], 1e-15);
}

TEST(BodyState, OfABarHasMomentumAlongItAlone) {
  test::SceneStates scene(test::rod(10));
  auto& rod = scene.states.at(0);
  for (int node = 0; node <= 10; ++node) rod.v[node] = node;
  rod.update_momentum();
  EXPECT_EQ(rod.totals.momentum_n_kg_m_s, 2.0 * 45.0 + 10.0) << "2 kg at nodes 1 to 9, 1 kg at node 10";
  EXPECT_EQ(rod.totals.momentum_t_kg_m_s, 0.0);
  EXPECT_EQ(rod.totals.angular_momentum_z_kg_m2_s, 0.0);
}

// 7 N over 0.1 s along x at (0.2, 0.4) m, where a support is, and along y at (0.1, 0.2) m, where a dashpot is.
TEST(BodyState, WithoutLoadsBooksOnlySupportsAndDashpots) {
  test::Plates plates("all_implicit");
  auto& plate = plates.states[1];
  plate.constrained = {{2 * plates.node_at(1, {0.2, 0.4})}};
  plate.dashpots = {{2 * plates.node_at(1, {0.1, 0.2}) + 1, 1.0, 0.0}};
  plate.account_external(
      0.1, [](int) { return 7.0; }, [](int) { return 1e-3; }, [](int) { return 0.5; });
  EXPECT_NEAR(plate.totals.energy_external_j, 2 * 7e-3, 1e-17);
  EXPECT_NEAR(plate.totals.impulse_n_kg_m_s, 0.7, 1e-15) << "of the dashpot";
  EXPECT_NEAR(plate.totals.impulse_t_kg_m_s, -0.7, 1e-15) << "of the support, t = (-1, 0)";
  EXPECT_NEAR(plate.totals.angular_impulse_z_kg_m2_s, (0.1 + 0.5) * 0.7 - (0.4 + 0.5) * 0.7, 1e-15) << "where it is";
}

// The weight of 80 kg at 10 m/s^2 for 0.1 s, while the plate falls by 1 mm; its centre is at x = 0.1 m.
TEST(BodyState, BooksALoadOnEveryNode) {
  test::Plates plates("all_implicit");
  auto& plate = plates.states[1];
  scene::Body heavy = plates.problem.scene.bodies[1];
  heavy.gravity_m_s2 = {0.0, -10.0};
  plate.external = scene::ExternalForce(heavy, plate.part);
  Eigen::VectorXd force(plate.part.dofs());
  plate.external.at(0.0, force);
  for (int window = 0; window < 2; ++window) {
    plate.account_external(
        0.1, [&](int dof) { return force[dof]; }, [](int dof) { return dof % 2 == 1 ? -1e-3 : 0.0; },
        [](int) { return 0.0; });
  }
  EXPECT_NEAR(plate.totals.energy_external_j, 2 * 0.8, 1e-14);
  EXPECT_NEAR(plate.totals.impulse_n_kg_m_s, 2 * -80.0, 1e-12);
  EXPECT_NEAR(plate.totals.impulse_t_kg_m_s, 0.0, 1e-15);
  EXPECT_NEAR(plate.totals.angular_impulse_z_kg_m2_s, 2 * -8.0, 1e-13);
}

TEST(BodyState, PutBackHasItsMotionAndTotalsButNotItsMassAgain) {
  test::SceneStates scene(test::rod(1, "initial_velocity_m_s = [3.0]"));
  auto& rod = scene.states.at(0);
  rod.totals.energy_external_j = 5.0;
  const auto before = motions_of(scene.states);
  rod.u.setConstant(1.0);
  rod.v.setConstant(2.0);
  rod.a.setConstant(4.0);
  rod.mass.setConstant(7.0);
  rod.totals.energy_external_j = 6.0;
  restore_motions(before, scene.states);
  EXPECT_THAT(list(rod.u), ElementsAre(0.0, 0.0));
  EXPECT_THAT(list(rod.v), ElementsAre(3.0, 3.0));
  EXPECT_THAT(list(rod.a), ElementsAre(0.0, 0.0));
  EXPECT_EQ(rod.totals.energy_external_j, 5.0);
  EXPECT_THAT(list(rod.mass), ElementsAre(7.0, 7.0));
}

// The implicit part of the left rod begins at the fourth of the rod's nodes.
TEST(BodyState, ThatIsNotFiniteIsNamedWithItsNodeInTheWholeBodyItsPlaceAndWindow) {
  const test::SceneStates scene(test::two_rods("hughes_liu"), "implicit");
  const auto& left = scene.states.at(0);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    Eigen::VectorXd u = Eigen::VectorXd::Ones(2);
    EXPECT_NO_THROW(require_finite(left, u, 17));
    u[0] = bad;
    try {
      require_finite(left, u, 17);
      FAIL() << bad;
    } catch (const SolverError& e) {
      EXPECT_THAT(e.what(),
                  testing::StartsWith("window 17: the displacement of body 'left' is not finite at node 3 (-1, 0) m"));
    }
  }
}

}  // namespace
}  // namespace ricochet::solver
