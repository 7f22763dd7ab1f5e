// A foreign body: which nodes of the scene's it shares, and what follows for the partition.
#include <gmock/gmock.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "common/problem/problem.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// The lower of two bodies joined to a foreign one; `joint`: where.
std::string joined(const std::string& text, const std::string& joint) {
  return text + "[[body]]\nname = \"base\"\nforeign = true\njoined_to = \"lower\"\n" + joint +
         "\n[[participant]]\nname = \"ours\"\nrole = \"explicit\"\nbodies = [\"lower\", \"upper\"]\n" +
         "[[participant]]\nname = \"theirs\"\nrole = \"explicit\"\nbodies = [\"base\"]\nexecutable = \"theirs\"\n" +
         "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
}

TEST(Joints, MakeTheLayerAtJoinedNodesImplicit) {
  const Problem problem = build_problem(load_text(joined_bars));
  ASSERT_EQ(problem.joints.size(), 1U);
  EXPECT_EQ(problem.joints[0].foreign, "tail");
  EXPECT_EQ(problem.joints[0].body, 0);
  EXPECT_THAT(problem.joints[0].nodes, ElementsAre(0));
  const BodyProblem& left = problem.bodies[0];
  EXPECT_THAT(left.implicit_element, ElementsAre(true, false, false, false, false, true, true, true, true, true));
  EXPECT_TRUE(left.joined_node[0]);
  EXPECT_EQ(std::count(left.joined_node.begin(), left.joined_node.end(), true), 1);
}

TEST(Joints, AreSharedByTheImplicitParticipantThoughNoElementOfOursIsExplicitThere) {
  const Problem problem = build_problem(load_text(joined_bars));
  const auto implicit = participant_parts(problem, problem.scene.participant("implicit"));
  std::vector<int> nodes;
  for (const int local : implicit.at(0).shared)
    nodes.push_back(implicit[0].part.body_node[static_cast<std::size_t>(local)]);
  EXPECT_THAT(nodes, ElementsAre(0, 1, 5)) << "the joint, and both ends of what is explicit";
  EXPECT_TRUE(participant_parts(problem, problem.scene.participant("far")).empty());
}

TEST(Joints, ArePlannedWithoutAWarning) {
  const Problem problem = build_problem(load_text(joined_bars));
  const Plan planned = plan(problem);
  EXPECT_THAT(planned.warnings, testing::IsEmpty());
  EXPECT_THAT(to_text(problem, planned), HasSubstr("note: \"tail\" is foreign: joined to \"left\" at 1 node;"));
  EXPECT_EQ(planned.participants.at(1).interface_nodes, 1);
  EXPECT_EQ(planned.participants.at(1).elements, 0);
}

/// In two and three components, from a surface and from a file in any order, with six digits.
TEST(Joints, AreTheNodesOfASurfaceOrOfAFile) {
  const SceneFolder folder;
  for (const auto& [text, nodes, expected] :
       {std::tuple{plates, "0.05, -0.3\n0, -0.3\n0.1, -0.300000001\n", std::vector<int>{0, 1, 2}},
        std::tuple{blocks, "0.1, 0, -0.3\n# a comment\n0, 0, -0.3\n", std::vector<int>{0, 1}}}) {
    folder.write(nodes, "nodes.csv");
    const Problem some = build_problem(load_scene(folder.write(joined(text, "interface_nodes = \"nodes.csv\""))));
    EXPECT_EQ(some.joints.at(0).nodes, expected);
    const Problem all = build_problem(load_scene(folder.write(joined(text, "surface = \"start\""))));
    EXPECT_EQ(all.joints.at(0).nodes.size(), some.scene.components() == 2 ? 5U : 12U);
    EXPECT_TRUE(std::is_sorted(all.joints[0].nodes.begin(), all.joints[0].nodes.end()));
  }
}

TEST(Joints, ThatAreNoNodesAreRefused) {
  const SceneFolder folder;
  const std::string scene = folder.write(joined(plates, "interface_nodes = \"nodes.csv\""));
  const auto refused = [&](const std::string& nodes) -> std::string {
    folder.write(nodes, "nodes.csv");
    try {
      (void)build_problem(load_scene(scene));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refused("0.06, -0.3\n"),
              testing::AllOf(testing::StartsWith(scene + ":23: body.base.interface_nodes: found the position "),
                             HasSubstr("0.06"),
                             HasSubstr("allowed: positions of nodes of \"lower\", the nearest of "
                                       "which is at"),
                             HasSubstr("0.05")));
  EXPECT_THAT(refused("0.05, -0.3\n0.05, -0.3\n"), HasSubstr("a second time; allowed: each node once"));
}

TEST(Joints, MayBeReachedByAWaveAtAnyTime) {
  const auto notes = [](const std::string& text) { return plan(build_problem(load_text(text))).notes; };
  EXPECT_THAT(notes(replaced(joined_bars, "end_s = 200e-6", "end_s = 60e-6")),
              testing::Not(testing::Contains(HasSubstr("end of \"left\""))));
}

}  // namespace
}  // namespace ricochet::scene
