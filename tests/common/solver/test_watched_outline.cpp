#include <gmock/gmock.h>

#include "common/solver/watched_outline.hpp"
#include "tests/support/contact_plates.hpp"
#include "tests/support/rods.hpp"

namespace ricochet::solver {
namespace {

using participant::OutlineNode;
using testing::ElementsAre;

/// Index of a body, node of the whole body and first displacement of what is watched.
std::vector<std::vector<double>> list(const std::vector<OutlineNode>& nodes) {
  std::vector<std::vector<double>> result;
  for (const auto& node : nodes)
    result.push_back({static_cast<double>(node.body), static_cast<double>(node.node), node.displacement_m.at(0)});
  return result;
}

const std::string with_a_third =
    test::replaced(test::two_rods("hughes_liu"), "[contact]", test::rod_body("third", 10, 2) + "[contact]");

TEST(WatchedOutline, IsEmptyWhereEveryTwoBodiesHaveAContact) {
  const test::ContactPlates plates("all_implicit");
  EXPECT_TRUE(WatchedOutline(plates.problem, plates.states).nodes(plates.states).empty());
}

// A third rod has no contact with the two, of which either could meet it.
TEST(WatchedOutline, OfRodsIsTheirEndsInTheNumbersOfTheWholeBody) {
  test::SceneStates outside(with_a_third, "explicit"), inside(with_a_third, "implicit");
  for (auto* scene : {&outside, &inside})
    for (auto& state : scene->states)
      for (int node = 0; node < state.part.nodes(); ++node)
        state.u[node] = state.part.mesh.position[static_cast<std::size_t>(node)][0];
  EXPECT_THAT(list(WatchedOutline(outside.problem, outside.states).nodes(outside.states)),
              ElementsAre(ElementsAre(0, 0, -4), ElementsAre(1, 4, 4), ElementsAre(2, 0, 10), ElementsAre(2, 2, 12)));
  EXPECT_THAT(list(WatchedOutline(inside.problem, inside.states).nodes(inside.states)),
              ElementsAre(ElementsAre(0, 4, 0), ElementsAre(1, 0, 0)));
}

TEST(WatchedOutline, OfAPlateLeavesOutItsInnerNodesAndHasBothComponents) {
  test::ContactPlates plates("all_implicit");
  plates.problem.contacts.clear();  // as if the scene had none
  auto& upper = plates.states[1];
  for (int dof = 0; dof < upper.part.dofs(); ++dof) upper.u[dof] = dof;
  const auto nodes = WatchedOutline(plates.problem, plates.states).nodes(plates.states);
  ASSERT_EQ(nodes.size(), 16U) << "eight of nine nodes of either plate";
  for (const auto& node : nodes) {
    if (node.body == 0) continue;
    EXPECT_NE(node.node, plates.node_at(1, {0.1, 0.2}));
    EXPECT_THAT(node.displacement_m, ElementsAre(2.0 * node.node, 2.0 * node.node + 1.0));
  }
}

}  // namespace
}  // namespace ricochet::solver
