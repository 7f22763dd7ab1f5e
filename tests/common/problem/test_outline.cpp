#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "common/problem/outline.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

using testing::HasSubstr;

Problem plates_problem() { return build_problem(load_text(plates)); }

std::vector<Eigen::Vector3d> everywhere(const Shape& shape, const Eigen::Vector2d& u) {
  return std::vector<Eigen::Vector3d>(shape.outline().nodes.size(), {u[0], u[1], 0.0});
}

TEST(Outline, HoldsNodesAndEdgesOfOneElementOnly) {
  const Problem problem = plates_problem();  // 4 x 6 elements
  const Outline outline = outline_of(problem.bodies[0].mesh);
  EXPECT_EQ(outline.nodes.size(), 20U);
  EXPECT_EQ(outline.edges.size(), 20U);
  const Problem line = build_problem(load_text(bars));
  EXPECT_THAT(outline_of(line.bodies[0].mesh).nodes, testing::ElementsAre(0, 20));
}

TEST(Overlap, OfPlatesIsHowDeepANodeLiesWithinTheOther) {
  const Problem problem = plates_problem();  // 0.2 m x 0.3 m each, edges of 0.05 m, in touch along y = 0
  Shape lower(problem.bodies[0]), upper(problem.bodies[1]);
  EXPECT_EQ(lower.overlap(upper).depth_m, 0.0) << "in touch";
  upper.move(everywhere(upper, {0.07, -0.02}));
  EXPECT_NEAR(lower.overlap(upper).depth_m, 0.02, 1e-12);
  EXPECT_NEAR(upper.overlap(lower).depth_m, 0.02, 1e-12);
  upper.move(everywhere(upper, {0.21, -0.02}));
  EXPECT_EQ(lower.overlap(upper).depth_m, 0.0) << "beside it";
  EXPECT_NEAR(lower.thickness(), 0.2, 1e-15);
}

TEST(Overlap, OfABodyWithinAnotherCounts) {
  const Problem problem = plates_problem();
  Shape lower(problem.bodies[0]), small(problem.bodies[1]);
  std::vector<Eigen::Vector3d> shrink;
  for (const int node : small.outline().nodes) {
    const Eigen::Vector3d x = problem.bodies[1].mesh.position[static_cast<std::size_t>(node)];
    shrink.push_back(Eigen::Vector3d(0.1, -0.15, 0.0) + 0.01 * (x - Eigen::Vector3d(0.1, 0.15, 0.0)) - x);
  }
  small.move(shrink);
  EXPECT_NEAR(lower.overlap(small).depth_m, 0.1, 1e-3);
  EXPECT_LT((lower.low() + lower.high() - small.low() - small.high()).norm(), 1e-15) << "with one middle";
  EXPECT_GT(lower.overlap(small, 0.05).depth_m, 0.09);
}

TEST(Overlap, KnowsRoundThatBoxesDoNot) {
  const Problem problem = plates_problem();
  Shape lower(problem.bodies[0]), upper(problem.bodies[1]);
  const Eigen::AngleAxisd turn(std::numbers::pi / 4, Eigen::Vector3d::UnitZ());
  std::vector<Eigen::Vector3d> turned;
  for (const int node : upper.outline().nodes) {
    const Eigen::Vector3d x = problem.bodies[1].mesh.position[static_cast<std::size_t>(node)];
    turned.push_back(turn * x + Eigen::Vector3d(0.25, -0.03, 0.0) - x);  // its lowest corner is at (0.25, -0.03)
  }
  upper.move(turned);
  EXPECT_LT(upper.low()[0], 0.2);
  EXPECT_EQ(lower.overlap(upper).depth_m, 0.0);
}

TEST(Overlap, OfSolidsIsHowDeepANodeLiesWithinTheOther) {
  const Problem problem = build_problem(load_text(blocks));  // 0.2 m x 0.3 m x 0.3 m each, in touch along z = 0
  Shape lower(problem.bodies[0]), upper(problem.bodies[1]);
  EXPECT_EQ(lower.outline().triangles.size(), 2U * 2U * (2 * 3 + 2 * 6 + 3 * 6));
  EXPECT_EQ(lower.overlap(upper).depth_m, 0.0) << "in touch";
  const auto moved = [&](double x, double y, double z) {
    return std::vector<Eigen::Vector3d>(upper.outline().nodes.size(), {x, y, z});
  };
  upper.move(moved(0.07, 0.05, -0.02));
  EXPECT_NEAR(lower.overlap(upper).depth_m, 0.02, 1e-12);
  EXPECT_NEAR(upper.overlap(lower).depth_m, 0.02, 1e-12);
  upper.move(moved(0.07, 0.31, -0.02));
  EXPECT_EQ(lower.overlap(upper).depth_m, 0.0) << "beside it";
  // Turned about y by 45 degrees, its lowest edge at (0.25, y, -0.03): boxes meet, bodies do not.
  const Eigen::AngleAxisd turn(std::numbers::pi / 4, Eigen::Vector3d::UnitY());
  std::vector<Eigen::Vector3d> turned;
  for (const int node : upper.outline().nodes) {
    const Eigen::Vector3d x = problem.bodies[1].mesh.position[static_cast<std::size_t>(node)];
    turned.push_back(turn * (x - Eigen::Vector3d(0.2, 0.0, 0.0)) + Eigen::Vector3d(0.25, 0.0, -0.03) - x);
  }
  upper.move(turned);
  EXPECT_LT(upper.low()[0], 0.2);
  EXPECT_LT(upper.low()[2], 0.0);
  EXPECT_EQ(lower.overlap(upper).depth_m, 0.0);
}

TEST(Overlap, OfBarsIsAnInterval) {
  const Problem problem = build_problem(load_text(bars));
  Shape left(problem.bodies[0]), right(problem.bodies[1]);
  right.move(everywhere(right, {-1.508e-3, 0.0}));
  EXPECT_NEAR(left.overlap(right).depth_m, 1e-3, 1e-15);
  right.move(everywhere(right, {-1.0, 0.0}));
  EXPECT_EQ(left.overlap(right).depth_m, 0.0) << "past it";
}

TEST(PairsWithoutContact, AreAllButTheContactsOne) {
  Problem problem = plates_problem();
  EXPECT_TRUE(pairs_without_contact(problem).empty());
  problem.bodies.push_back(problem.bodies.front());
  EXPECT_EQ(pairs_without_contact(problem).size(), 2U);
  problem.contacts.clear();
  EXPECT_EQ(pairs_without_contact(problem).size(), 3U);
}

TEST(ContactsToWatch, AreNoneOfBodiesThatLieApartFromTheirMeshes) {
  Problem problem = plates_problem();
  problem.contacts.front().turns = true;
  EXPECT_EQ(contacts_to_watch(problem).size(), 1U);
  problem.contacts.push_back(problem.contacts.front());
  problem.scene.contacts.push_back(problem.scene.contacts.front());
  EXPECT_EQ(contacts_to_watch(problem).size(), 2U);
  problem.scene.contacts.back().initial_gap_m = 1e-3;
  EXPECT_TRUE(contacts_to_watch(problem).empty());
  problem.scene.contacts.back() = problem.scene.contacts.front();
  problem.scene.contacts.back().nose_radius_m = 1.0;
  EXPECT_TRUE(contacts_to_watch(problem).empty()) << "another contact of the two has a nose";
}

/// A block above "rigid_plane", or above a plate, and a post of it that reaches 1 mm below its surface.
std::string block_with_post(const std::string& plate, double gap_m) {
  return fmt::format(
      "model = \"plane_strain\"\n{0}[[body]]\nname = \"block\"\nmaterial = \"steel_a36\"\n[body.mesh]\n"
      "tie = [{{ surfaces = [\"top.start\", \"post.end\"] }}]\npiece = [\n"
      "{{ name = \"top\", height_m = 0.01, length_m = 0.004, elements = [10, 4] }},\n"
      "{{ name = \"post\", height_m = 0.002, length_m = 0.001, start_m = -0.001, elements = [2, 2] }}]\n"
      "[contact]\nsurfaces = [\"block.top.start\", \"{1}\"]\ninitial_gap_m = {2}\n[time]\nstep_s = 1e-8\n"
      "end_s = 1e-6\n",
      plate, plate.empty() ? "rigid_plane" : "plate.end", gap_m);
}

TEST(ContactsToWatch, AreThoseOfABodyThatReachesBeyondItsSurface) {
  const auto watched = [](const std::string& text) { return contacts_to_watch(build_problem(load_text(text))).size(); };
  const std::string plate =
      "[[body]]\nname = \"plate\"\nmaterial = \"steel_a36\"\n"
      "mesh = { height_m = 0.02, length_m = 0.004, start_m = -0.004, elements = [10, 4] }\n";
  EXPECT_EQ(watched(plates), 0U);
  EXPECT_EQ(watched(block_with_post(plate, 0.002)), 1U);
  EXPECT_EQ(watched(block_with_post("", 0.002)), 1U);
  EXPECT_EQ(watched(block_with_post("", 0.0005)), 0U) << "in a hole of the rigid plane from the start";
  for (const auto& [gap_m, count] : {std::pair(0.002, 1U), std::pair(0.0005, 0U)})
    EXPECT_EQ(
        watched(replaced(block_with_post("", gap_m), "\"rigid_plane\"]", "\"rigid_cylinder\"]\nrigid_radius_m = 1.0")),
        count);
  const std::string as_high =
      "{ name = \"post\", height_m = 0.002, length_m = 0.004, elements = [2, 4], place = { moved_m = [0.01, 0.0] } }";
  const std::string beside =
      replaced(replaced(block_with_post(plate, 0.002), "\"top.start\", \"post.end\"", "\"top.outer\", \"post.inner\""),
               "{ name = \"post\", height_m = 0.002, length_m = 0.001, start_m = -0.001, elements = [2, 2] }", as_high);
  EXPECT_EQ(watched(beside), 0U) << "as high as the surface";
}

std::string refusal(const std::string& text) {
  try {
    (void)plan(build_problem(load_text(text)));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(NumberOfSteps, IsBounded) {
  for (const std::string& text :
       {replaced(bars, "end_s = 200e-6", "end_s = 1e18"), replaced(bars, "step_s = 2.226e-6", "step_s = 1e-300")}) {
    EXPECT_THAT(refusal(text),
                testing::AllOf(HasSubstr("time.end_s: found"), HasSubstr("allowed: an end after at most 1e+15 steps")));
  }
  EXPECT_EQ(refusal(replaced(bars, "end_s = 200e-6", "end_s = 2e9")), "");
}

TEST(ImpactUpdate, HasNoEffectWithoutAnImplicitSide) {
  const std::string penalty =
      replaced(bars, "surfaces", "enforcement = \"penalty\"\npenalty_pa_m = 1e9\nimpact_update = \"mass\"\nsurfaces");
  EXPECT_THAT(
      refusal(penalty + "[coupling]\nprotocol = \"all_explicit\"\n"),
      testing::AllOf(HasSubstr("contact.impact_update: found \"mass\""), HasSubstr("only with an implicit side")));
  EXPECT_EQ(refusal(penalty), "");
}

TEST(MultiplierUpdate, OfAnImplicitSideIsRefusedUnderAllExplicit) {
  const auto scene = [](const std::string& law) {
    return replaced(bars, "surfaces", "multiplier_update = \"" + law + "\"\nsurfaces") +
           "\n[coupling]\nprotocol = \"all_explicit\"\n";
  };
  EXPECT_THAT(refusal(scene("fully_implicit")),
              testing::AllOf(HasSubstr("contact.multiplier_update: found \"fully_implicit\""),
                             HasSubstr("\"trapezoidal_reset\" or \"massless\"")));
  EXPECT_EQ(refusal(scene("massless")), "");
}

TEST(RegularisedFriction, CreepsAndSaysSo) {
  const std::string text =
      replaced(cylinders, "friction_coefficient = 0.1",
               "friction_coefficient = 0.1\nfriction_law = \"regularised\"\nfriction_regularisation_s_m = 0.5");
  EXPECT_THAT(plan(build_problem(load_text(text))).warnings,
              testing::Contains(testing::AllOf(HasSubstr("1/xi = 2 m/s"), HasSubstr("creeps"))));
}

}  // namespace
}  // namespace ricochet::scene
