#include <gmock/gmock.h>

#include <cmath>

#include "common/body/free_motion.hpp"
#include "tests/support/rods.hpp"

namespace ricochet::solver {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;

// Nodes of 1, 2 and 1 kg, of which the first is held: two displacements, then two velocities.
const std::string loaded = test::rod(2,
                                     "support = [{ surface = \"start\", fixed = [\"x\"] }]\n"
                                     "initial_displacement_m = { start = [0.0], end = [0.75] }\n"
                                     "initial_velocity_m_s = [3.0]\ngravity_m_s2 = [10.0]\n");

TEST(FreeMotion, ScaledIsTheRootOfAnEnergy) {
  const test::SceneStates scene(loaded);
  std::vector<double> row, scale;
  read_motion(scene.states, 0.5, row, scale);
  EXPECT_THAT(row, ElementsAre(0.375, 0.75, 3.0, 3.0));
  const double root = std::sqrt(2.0);
  EXPECT_THAT(scale, ElementsAre(DoubleEq(root / 0.5), DoubleEq(1.0 / 0.5), DoubleEq(root), DoubleEq(1.0)));
}

TEST(FreeMotion, LoadedIsReadAgain) {
  test::SceneStates scene(test::two_rods("all_explicit"));
  std::vector<double> given, row, scale;
  for (int i = 0; i < 20; ++i) given.push_back(1.0 / (1.0 + i));  // two motions of five nodes for two rods
  load_motion(given, scene.states);
  read_motion(scene.states, 0.1, row, scale);
  EXPECT_EQ(row, given);
  EXPECT_EQ(scene.states[1].v[4], given.back()) << "the last velocity of the last rod";
}

TEST(FreeMotion, LoadedIsThatOfAHomogeneousBody) {
  test::SceneStates scene(loaded);
  auto& rod = scene.states.at(0);
  rod.dashpots = {{2, 1.0, 3.0}};
  rod.constrained.at(0).motion.displacement_m = 5.0;
  load_motion({1.0, 2.0, 4.0, 8.0}, scene.states);
  EXPECT_EQ(rod.u, Eigen::Vector3d(0.0, 1.0, 2.0));
  EXPECT_EQ(rod.v, Eigen::Vector3d(0.0, 4.0, 8.0));
  EXPECT_TRUE(rod.external.zero());
  EXPECT_EQ(rod.constrained.at(0).at(1.0), 0.0);
  EXPECT_EQ(rod.dashpots.at(0).force(0.0), 0.0);
}

}  // namespace
}  // namespace ricochet::solver
