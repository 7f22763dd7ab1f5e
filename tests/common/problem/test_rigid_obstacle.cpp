#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "common/problem/problem.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

/// A block of 0.2 x 0.3 x 0.3 m, 4 x 6 x 3 elements, whose lower face, z = 0, is above an obstacle.
std::string block_above(const std::string& obstacle, const std::string& more) {
  return R"(model = "solid"
[[body]]
name = "block"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.3, height_m = 0.2, width_m = 0.3, elements = [4, 6, 3] }
[contact]
surfaces = ["block.start", ")" +
         obstacle + "\"]\nrigid_radius_m = 0.21\n" + more + R"(
[time]
safety_factor = 0.9
end_s = 1.0
[coupling]
protocol = "all_explicit"
)";
}

/// Every node of the face that lies above the obstacle and no other is in a pair, which has the distance and the
/// direction to a middle that is 0.21 m below the face, and the gap on top.
void expect_pairs(const std::string& text, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& middle_for,
                  double gap_m) {
  const Problem problem = build_problem(load_text(text));
  const ContactGeometry& contact = problem.contacts.front();
  EXPECT_TRUE(contact.round);
  const auto& mesh = problem.bodies[0].mesh;
  std::size_t above = 0;
  for (const auto& x : mesh.position) {
    const Eigen::Vector3d to = middle_for(x) - x;
    above += x[2] == 0.0 && to.head<2>().norm() < 0.21;
  }
  EXPECT_EQ(contact.pairs.size(), above);
  for (const ContactPair& pair : contact.pairs) {
    const Eigen::Vector3d& x = mesh.position[static_cast<std::size_t>(pair.node_a)];
    const Eigen::Vector3d to = middle_for(x) - x;
    EXPECT_LT((pair.normal - to.normalized()).norm(), 1e-14) << x.transpose();
    EXPECT_NEAR(pair.gap0_m, to.norm() - 0.21 - gap_m * pair.normal[2], 1e-15) << x.transpose();
    EXPECT_TRUE(pair.b.empty());
  }
}

TEST(RigidObstacle, OfASphereNodesHaveTheDistanceAndTheNormal) {
  expect_pairs(
      block_above("rigid_sphere", ""), [](const auto&) { return Eigen::Vector3d(0.0, 0.0, -0.21); }, 0.0);
  expect_pairs(
      block_above("rigid_sphere", "rigid_place_m = [0.1, 0.15, 7.0]\ninitial_gap_m = 0.01"),
      [](const auto&) { return Eigen::Vector3d(0.1, 0.15, -0.21); }, 0.01);
}

TEST(RigidObstacle, OfACylinderTheyAreThoseAcrossIt) {
  expect_pairs(
      block_above("rigid_cylinder", "rigid_axis = \"y\"\nrigid_place_m = [0.05, 0.0, 0.0]"),
      [](const auto& x) { return Eigen::Vector3d(0.05, x[1], -0.21); }, 0.0);
  expect_pairs(
      block_above("rigid_cylinder", "rigid_axis = \"x\"\ninitial_gap_m = 0.02"),
      [](const auto& x) { return Eigen::Vector3d(x[0], 0.0, -0.21); }, 0.02);
}

/// Beside the body it touches the node that it meets first.
TEST(RigidObstacle, TouchesTheSurfaceWhereverItIs) {
  const Problem problem = build_problem(load_text(block_above("rigid_sphere", "rigid_place_m = [-0.1, 0.0, 0.0]")));
  const auto& pairs = problem.contacts.front().pairs;
  EXPECT_EQ(pairs.front().gap0_m, 0.0);
  const Eigen::Vector3d expected(-0.1 / 0.21, 0.0, -std::sqrt(1.0 - std::pow(0.1 / 0.21, 2)));
  EXPECT_LT((pairs.front().normal - expected).norm(), 1e-14);
  for (const ContactPair& pair : pairs) EXPECT_GE(pair.gap0_m, 0.0);
}

/// A mesh that repeats has an obstacle in every period.
TEST(RigidObstacle, RepeatsWithTheMesh) {
  const auto pairs_of = [](const std::string& place) {
    std::string text = block_above("rigid_cylinder", "rigid_axis = \"y\"\nrigid_place_m = " + place);
    text = replaced(text, "elements = [4, 6, 3]", "elements = [4, 6, 3], periodic_across = true");
    return build_problem(load_text(text)).contacts.front().pairs;
  };
  const auto here = pairs_of("[0.15, 0.0, 0.0]"), there = pairs_of("[-0.05, 0.0, 0.0]");
  ASSERT_EQ(here.size(), 24U);
  ASSERT_EQ(there.size(), here.size());
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_EQ(here[i].node_a, there[i].node_a);
    EXPECT_NEAR(here[i].gap0_m, there[i].gap0_m, 1e-15);
  }
}

}  // namespace
}  // namespace ricochet::scene
