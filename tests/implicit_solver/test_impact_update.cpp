#include <gtest/gtest.h>

#include <cmath>

#include "implicit_solver/implicit_solver.hpp"
#include "tests/support/scene_file.hpp"

// Eq. 25-27 of the paper with numbers worked out by hand. In so short a first window no force moves anything, and what
// is left of the velocities of a closed pair is its update.

namespace ricochet::implicit_solver {
namespace {

// Lower: C_z = sqrt(1.2 E / rho) = 3000 m/s, C_t = sqrt(E / (2.5 rho)) = 1000 sqrt(3) m/s, rho C = 6e6 and 2e6 sqrt(3).
// Upper: C_z = sqrt(E / rho) = 2000 m/s, C_t = sqrt(E / (2 rho)) = 1000 sqrt(2) m/s, rho C = 8e6 and 4e6 sqrt(2).
// Masses per area of the contact nodes: 2000 * 0.02 / 2 = 20 and 4000 * 0.03 / 2 = 60.
std::string blocks(const std::string& update, const std::string& friction_coefficient) {
  return R"(
model = "plane_strain"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 15e9, poisson_ratio = 0.25, density_kg_m3 = 2000.0 }
mesh = { start_m = -0.04, length_m = 0.04, height_m = 0.01, elements = [2, 2] }
initial_velocity_m_s = [2.0, 7.0]
[[body]]
name = "upper"
material = { youngs_modulus_pa = 16e9, poisson_ratio = 0.0, density_kg_m3 = 4000.0 }
mesh = { length_m = 0.06, height_m = 0.01, elements = [2, 2] }
initial_velocity_m_s = [-1.0, 0.0]
[contact]
surfaces = ["lower.end", "upper.start"]
enforcement = "penalty"
penalty_pa_m = 1e12
impact_update = ")" +
         update + R"("
friction_coefficient = )" +
         friction_coefficient + R"(
[time]
step_s = 1e-10
end_s = 1e-9
[coupling]
protocol = "all_implicit"
)";
}

struct Motion {
  Eigen::Vector2d lower, upper;
};

/// Velocities of every pair after the first window; all pairs do the same.
Motion after_one_window(const std::string& text) {
  const test::TemporaryFolder folder;
  const auto problem = scene::build_problem(scene::load_scene(folder.write(text)));
  ImplicitSolver solver(problem, problem.scene.participants.at(0).name);
  static_cast<void>(solver.describe());
  participant::Setup setup;
  setup.clock = problem.clock.size_s();
  participant::LinkOutput output;
  solver.initialize(setup, output);
  solver.synchronise(participant::Integration::implicit_newmark, {}, output);
  solver.advance(1, {}, output);
  solver.accept();
  EXPECT_EQ(solver.contact_status().pairs_closed, 3);
  Motion motion;
  for (const auto& pair : problem.contacts.front().pairs) {
    const Eigen::Vector2d lower = solver.state().bodies.at(0).v.segment<2>(2 * pair.node_a);
    const Eigen::Vector2d upper = solver.state().bodies.at(1).v.segment<2>(2 * pair.b.at(0).node);
    if (&pair != problem.contacts.front().pairs.data()) {
      EXPECT_LT((lower - motion.lower).norm() + (upper - motion.upper).norm(), 1e-4);
    }
    motion = {lower, upper};
  }
  return motion;
}

TEST(ImpactUpdate, TakesTheImpedanceWeightedMeanAlongAndAcrossTheNormal) {
  const Motion motion = after_one_window(blocks("impedance", "5.0"));  // 3/7 of a slip per closing: sticks
  const double normal = (6.0 * 7.0 + 8.0 * 0.0) / (6.0 + 8.0);
  const double tangential =
      (std::sqrt(3.0) * 2.0 - 2.0 * std::sqrt(2.0) * 1.0) / (std::sqrt(3.0) + 2.0 * std::sqrt(2.0));
  EXPECT_NEAR(normal, 3.0, 1e-12);
  EXPECT_NEAR(tangential, 0.139388, 1e-6);
  for (const auto& velocity : {motion.lower, motion.upper}) {
    EXPECT_NEAR(velocity[1], normal, 1e-4);
    EXPECT_NEAR(velocity[0], tangential, 1e-4);
  }
}

TEST(ImpactUpdate, TakesTheMassWeightedMeanIfAskedTo) {
  const Motion motion = after_one_window(blocks("mass", "5.0"));
  for (const auto& velocity : {motion.lower, motion.upper}) {
    EXPECT_NEAR(velocity[1], (20.0 * 7.0 + 60.0 * 0.0) / 80.0, 1e-4);
    EXPECT_NEAR(velocity[0], (20.0 * 2.0 - 60.0 * 1.0) / 80.0, 1e-4);
  }
}

TEST(ImpactUpdate, LeavesTheTangentOfASlippingPairAlone) {
  const Motion motion = after_one_window(blocks("impedance", "0.001"));
  EXPECT_NEAR(motion.lower[1], 3.0, 1e-4);
  EXPECT_NEAR(motion.upper[1], 3.0, 1e-4);
  EXPECT_NEAR(motion.lower[0], 2.0, 0.03) << "what friction takes is 0.001 of what the update gives along the normal";
  EXPECT_NEAR(motion.upper[0], -1.0, 0.03);
}

TEST(ImpactUpdate, IsNoneUnlessAskedFor) {
  const Motion motion = after_one_window(blocks("none", "5.0"));
  EXPECT_LT((motion.lower - Eigen::Vector2d(2.0, 7.0)).norm(), 1e-2);
  EXPECT_LT((motion.upper - Eigen::Vector2d(-1.0, 0.0)).norm(), 1e-2);
}

}  // namespace
}  // namespace ricochet::implicit_solver
