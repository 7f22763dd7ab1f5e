#include <gmock/gmock.h>

#include <limits>

#include "common/base/error.hpp"
#include "common/solver/axial_stress_shares.hpp"
#include "tests/support/rods.hpp"

namespace ricochet::solver {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

const std::string asked = test::two_rods("hughes_liu") + "[output]\naxial_stress_every = 1\n";

/// Row of a participant whose rods have the displacement x^2 / 2: the mean strain of an element is the x of its middle.
std::vector<double> row_of(test::SceneStates& scene, const AxialStressShares& given) {
  AxialStressShares shares = given;
  for (auto& state : scene.states)
    for (int node = 0; node < state.part.nodes(); ++node) {
      const double x = state.part.mesh.position[static_cast<std::size_t>(node)][0];
      state.u[node] = 0.5 * x * x;
    }
  std::vector<double> row;
  shares.append(scene.states, 1, row);
  return row;
}

// A layer is as thick as an element, E = 8 Pa.
TEST(AxialStressShares, AreOfTheLayersInWhichAParticipantHasElements) {
  test::SceneStates outside(asked, "explicit"), inside(asked, "implicit");
  const AxialStressShares of_outside(outside.problem, outside.states), of_inside(inside.problem, inside.states);
  EXPECT_THAT(of_outside.columns(),
              ElementsAre("left/-4/-3/1", "left/-3/-2/1", "left/-2/-1/1", "right/1/2/1", "right/2/3/1", "right/3/4/1"));
  EXPECT_THAT(of_inside.columns(), ElementsAre("left/-1/0/1", "right/0/1/1"));
  const auto near = [](double value) { return DoubleNear(value, 1e-13); };
  EXPECT_THAT(row_of(outside, of_outside), ElementsAre(near(-28), near(-20), near(-12), near(12), near(20), near(28)));
  EXPECT_THAT(row_of(inside, of_inside), ElementsAre(near(-4), near(4)));
}

TEST(AxialStressShares, AreNoneUnlessTheSceneAsks) {
  test::SceneStates scene(test::two_rods("hughes_liu"), "explicit");
  const AxialStressShares shares(scene.problem, scene.states);
  EXPECT_TRUE(shares.columns().empty());
  EXPECT_TRUE(row_of(scene, shares).empty());
}

TEST(AxialStressShares, RefuseADisplacementThatIsNotFinite) {
  test::SceneStates scene(asked, "explicit");
  AxialStressShares shares(scene.problem, scene.states);
  scene.states[1].u[0] = std::numeric_limits<double>::infinity();
  std::vector<double> row;
  EXPECT_THROW(shares.append(scene.states, 1, row), SolverError);
}

}  // namespace
}  // namespace ricochet::solver
