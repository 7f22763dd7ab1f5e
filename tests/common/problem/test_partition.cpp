#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/base/error.hpp"
#include "common/problem/automatic_partition.hpp"
#include "common/problem/critical_step.hpp"
#include "common/problem/problem.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/places.hpp"

namespace ricochet::scene {
namespace {

using testing::ElementsAre;

Problem build(const std::string& text) { return build_problem(load_text(text)); }

int count(const std::vector<bool>& flags) { return static_cast<int>(std::count(flags.begin(), flags.end(), true)); }

const std::string lengths = "{ left = 0.0635, right = 0.0635 }";

TEST(ImplicitLength, TakesElementsWhollyInside) {
  const Problem problem = build(cylinders);  // elements of 2.5 mm, 5 mm and 7.5 mm
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 2 * 4);
  EXPECT_EQ(count(problem.bodies[1].implicit_element), 3 * 4);
  EXPECT_EQ(count(problem.bodies[0].implicit_node), 3 * 5);
  for (int e = 0; e < 32; ++e) EXPECT_EQ(problem.bodies[0].implicit_element[static_cast<std::size_t>(e)], e >= 24);
  for (int e = 0; e < 32; ++e) EXPECT_EQ(problem.bodies[1].implicit_element[static_cast<std::size_t>(e)], e < 12);
}

TEST(ImplicitLength, ZeroLeavesTheContactNodesImplicitAndShared) {
  const Problem problem = build(replaced(bars, lengths, "{ left = 0.0, right = 0.0635 }"));
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 0);
  EXPECT_EQ(count(problem.bodies[0].implicit_node), 1);
  const auto implicit = participant_parts(problem, problem.scene.participant("implicit"));
  ASSERT_EQ(implicit.size(), 2U);
  EXPECT_THAT(implicit[0].part.body_node, ElementsAre(20));
  EXPECT_TRUE(implicit[0].part.body_element.empty());
  EXPECT_THAT(implicit[0].shared, ElementsAre(0));
  EXPECT_EQ(implicit[0].part.lumped_mass[0], 0.0);
  const auto explicit_parts = participant_parts(problem, problem.scene.participant("explicit"));
  EXPECT_THAT(explicit_parts[0].shared, ElementsAre(20));
}

TEST(ImplicitLength, ZeroStillTakesTheLayerThatMovesMasslessNodes) {
  const std::string massless = replaced(bars, "[contact]\n", "[contact]\nmultiplier_update = \"massless\"\n");
  const Problem problem = build(replaced(massless, lengths, "{ left = 0.0, right = 0.0635 }"));
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 1);
  EXPECT_TRUE(problem.bodies[0].implicit_element.back()) << "the one at the contact";
  EXPECT_EQ(count(problem.bodies[1].implicit_element), 5);
}

TEST(ImplicitLength, ZeroIsRefusedByADualProtocol) {
  const std::string dual =
      replaced(bars, lengths, "{ left = 0.0, right = 0.0635 }") + "\n[coupling]\nprotocol = \"prakash_hjelmstad\"\n";
  try {
    static_cast<void>(build(dual));
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("coupling.protocol: found \"prakash_hjelmstad\" and an explicit element"));
    EXPECT_THAT(error.what(), testing::HasSubstr("implicit elements all around"));
  }
}

TEST(ImplicitLength, BeyondTheBodyTakesAllOfIt) {
  const Problem problem = build(replaced(bars, lengths, "{ left = 9.0, right = 0.0635 }"));
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 20);
  const auto explicit_parts = participant_parts(problem, problem.scene.participant("explicit"));
  ASSERT_EQ(explicit_parts.size(), 1U);
  EXPECT_EQ(explicit_parts[0].body, 1);
  const auto implicit = participant_parts(problem, problem.scene.participant("implicit"));
  EXPECT_TRUE(implicit[0].shared.empty());
}

TEST(AutomaticRule, TakesFineElementsAndTheContactLayer) {
  // Sizes grow from the contact of the right bar: 20 elements, last/first = 100. Step 2 us holds for h >= c dt.
  const std::string graded = replaced(bars, "start_m = 0.508e-3, length_m = 0.254, elements = 20",
                                      "start_m = 0.508e-3, length_m = 0.254, elements = 20, grading = 100.0");
  const Problem problem = build(replaced(graded, "implicit_length_m = " + lengths, "rule = \"auto\""));
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 1);
  EXPECT_TRUE(problem.bodies[0].implicit_element[19]);
  const double shortest = 2.226e-6 * std::sqrt(206.8e9 / 7844.066);
  const auto& right = problem.bodies[1];
  for (std::size_t e = 0; e < 20; ++e) {
    const double size = right.mesh.position[e + 1][0] - right.mesh.position[e][0];
    EXPECT_EQ(right.implicit_element[e], e == 0 || size < shortest) << e;
  }
}

TEST(AutomaticRule, TakesFromAGradedMeshWhatTheElementsOwnFrequenciesSay) {
  const Scene scene = load_scene(test::source_folder() + "/configs/rounded_striker.toml");
  const Problem problem = build_problem(scene);
  for (int index = 0; index < 2; ++index) {
    const BodyProblem& body = problem.bodies[static_cast<std::size_t>(index)];
    std::vector<bool> contact(body.mesh.position.size(), false);
    for (const ContactPair& pair : problem.contacts.front().pairs)
      contact[static_cast<std::size_t>(index == problem.contacts.front().body_a ? pair.node_a : pair.b.at(0).node)] =
          true;
    for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
      const auto& nodes = body.mesh.elements[static_cast<std::size_t>(e)];
      const bool touches =
          std::any_of(nodes.begin(), nodes.end(), [&](int n) { return contact[static_cast<std::size_t>(n)]; });
      const double critical = 2.0 / std::sqrt(fem::element_max_frequency_squared(body.section, body.material,
                                                                                 fem::element_geometry(body.mesh, e)));
      ASSERT_EQ(body.implicit_element[static_cast<std::size_t>(e)], touches || critical < *scene.time.step_s) << e;
    }
  }
}

/// An element of h/2 between one of h and one of 3/2 h: the mean at its nodes is 4 c^2 over the product of the two
/// lengths, so that both together bear 0.95 sqrt(1/2) h/c where it alone would bear h/(2 c).
TEST(AutomaticRule, TakesABadElementOnlyWhereItsNeighboursDoNotMakeUpForIt) {
  BodyProblem body = build(bars).bodies[0];
  const double h = body.mesh.position[1][0] - body.mesh.position[0][0], h_over_c_s = h / std::sqrt(206.8e9 / 7844.066);
  body.mesh.position[10][0] -= 0.5 * h;  // element 9 is short
  const auto implicit_in = [&](double step_s) { return automatic_elements(body, {20}, step_s); };
  for (const double share : {0.51, 0.67}) {
    const auto inside = implicit_in(share * h_over_c_s);
    EXPECT_EQ(count(inside), 1) << "the contact layer";
    std::vector<bool> is_explicit = inside;
    is_explicit.flip();
    EXPECT_TRUE(is_stable_step(body, is_explicit, share * h_over_c_s)) << share;
  }
  for (const double share : {0.68, 0.9}) {
    const auto inside = implicit_in(share * h_over_c_s);
    EXPECT_EQ(count(inside), 2) << share;
    EXPECT_TRUE(inside[9]) << share;
  }
}

/// All that is left explicit bears the step, and not because nothing is.
TEST(AutomaticRule, LeavesTetrahedraThatBearTheStepTogether) {
  Scene scene = load_scene(test::source_folder() + "/configs/ball_on_plate.toml");
  for (const double step_s : {3e-8, 9e-8}) {
    scene.time.step_s = step_s;
    const Problem problem = build_problem(scene);
    int spared = 0;
    for (int index = 0; index < 2; ++index) {
      const BodyProblem& body = problem.bodies[static_cast<std::size_t>(index)];
      std::vector<bool> is_explicit = automatic_elements(body, contact_nodes(problem.contacts, index), step_s);
      is_explicit.flip();
      EXPECT_TRUE(is_stable_step(body, is_explicit, step_s)) << body.name << step_s;
      for (int e = 0; e < static_cast<int>(is_explicit.size()); ++e)
        spared += is_explicit[static_cast<std::size_t>(e)] && element_critical_step(body, e) < step_s;
    }
    EXPECT_GT(spared, 50) << step_s;
  }
}

TEST(BodyLumpedMass, IsThatOfTheAssembledBodyToTheBit) {
  const Problem problem = build(cylinders);
  for (const BodyProblem& body : problem.bodies) {
    std::vector<int> all(body.mesh.elements.size());
    std::iota(all.begin(), all.end(), 0);
    const fem::Part part = fem::extract_part(body.mesh, body.name, body.section, body.material, all);
    EXPECT_EQ(body_lumped_mass(body), part.lumped_mass);
    EXPECT_EQ(critical_time_step(body, part, false, 0.0),
              critical_time_step(body, std::vector<bool>(all.size(), true), false, 0.0));
  }
}

TEST(AutomaticRule, IsTheDefault) {
  const std::string text = replaced(bars, "[partition]\nimplicit_length_m = " + lengths + "\n", "");
  const Problem problem = build(text);
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 1);
  EXPECT_EQ(count(problem.bodies[1].implicit_element), 1);
}

/// A scene that says nothing of partition and step: the step is that of the explicit elements.
TEST(AutomaticRule, IsTheContactLayerWithoutAStep) {
  std::string text = replaced(bars, "[partition]\nimplicit_length_m = " + lengths + "\n", "");
  text = replaced(text, "step_s = 2.226e-6", "safety_factor = 0.5");
  const Problem problem = build(text);
  EXPECT_EQ(count(problem.bodies[0].implicit_element), 1);
  EXPECT_EQ(count(problem.bodies[1].implicit_element), 1);
  const double critical_s = 0.254 / 20 / std::sqrt(206.8e9 / 7844.066);
  EXPECT_NEAR(problem.clock.size_s(1), 0.5 * critical_s, 1e-3 * critical_s);
}

TEST(Baselines, MakeEverythingOfOneKindAndShareNothing) {
  const Problem implicit = build(replaced(cylinders, "hughes_liu", "all_implicit"));
  EXPECT_EQ(count(implicit.bodies[0].implicit_element), 32);
  EXPECT_EQ(count(implicit.bodies[0].implicit_node), 45);
  const Problem all_explicit = build(replaced(cylinders, "hughes_liu", "all_explicit"));
  EXPECT_EQ(count(all_explicit.bodies[0].implicit_element), 0);
  EXPECT_EQ(count(all_explicit.bodies[0].implicit_node), 0);
  for (const Problem* problem : {&implicit, &all_explicit}) {
    const auto parts = participant_parts(*problem, problem->scene.participants.at(0));
    ASSERT_EQ(parts.size(), 2U);
    for (const ParticipantPart& part : parts) {
      EXPECT_EQ(part.part.nodes(), 45);
      EXPECT_EQ(part.part.body_element.size(), 32U);
      EXPECT_TRUE(part.shared.empty());
    }
  }
}

TEST(ParticipantParts, CoverEachElementOnceAndAgreeOnSharedNodes) {
  const Problem problem = build(cylinders);
  const auto implicit = participant_parts(problem, problem.scene.participant("implicit"));
  const auto explicit_parts = participant_parts(problem, problem.scene.participant("explicit"));
  ASSERT_EQ(implicit.size(), 2U);
  ASSERT_EQ(explicit_parts.size(), 2U);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(implicit[b].part.body_element.size() + explicit_parts[b].part.body_element.size(), 32U);
    ASSERT_EQ(implicit[b].shared.size(), 5U);
    ASSERT_EQ(explicit_parts[b].shared.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
      const int of_implicit = implicit[b].part.body_node[static_cast<std::size_t>(implicit[b].shared[i])];
      EXPECT_EQ(of_implicit, explicit_parts[b].part.body_node[static_cast<std::size_t>(explicit_parts[b].shared[i])]);
    }
  }
}

TEST(ParticipantParts, OnePerBodyGivesTheSamePartsAsOneForBoth) {
  const std::string split = replaced(
      cylinders, "[output]\nfields_every = 0\n",
      "[[participant]]\nname = \"back\"\nrole = \"explicit\"\nbodies = [\"carbide\"]\n[[participant]]\nname = \"i\"\n"
      "role = \"implicit\"\n[[participant]]\nname = \"front\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n");
  const Problem one = build(cylinders), two = build(split);
  const auto both = participant_parts(one, one.scene.participant("explicit"));
  const auto front = participant_parts(two, two.scene.participant("front"));
  const auto back = participant_parts(two, two.scene.participant("back"));
  ASSERT_EQ(front.size(), 1U);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(front[0].part.body_node, both[0].part.body_node);
  EXPECT_EQ(back[0].part.body_node, both[1].part.body_node);
  EXPECT_EQ(back[0].shared, both[1].shared);
}

TEST(ExternalForce, IsTractionTimesAreaTimesFactorPlusWeight) {
  const Problem problem = build(replaced(cylinders, "initial_velocity_m_s = [0.0, 30.0]",
                                         "gravity_m_s2 = [0.0, -9.81]\n"
                                         "traction = [{ surface = \"start\", traction_pa = [0.0, 1e6], "
                                         "amplitude = { time_s = [0.0, 2.0], factor = [0.0, 1.0] } }]"));
  double total = 0.0;
  for (const ParticipantSpec& participant : problem.scene.participants) {
    for (const ParticipantPart& part : participant_parts(problem, participant)) {
      if (part.body != 0) continue;
      const ExternalForce external(problem.scene.bodies[0], part.part);
      Eigen::VectorXd force = Eigen::VectorXd::Ones(part.part.dofs());
      external.at(1.0, force);
      for (int i = 1; i < force.size(); i += 2) total += force[i];
      for (int i = 0; i < force.size(); i += 2) EXPECT_EQ(force[i], 0.0);
    }
  }
  const double area = std::numbers::pi * 0.004 * 0.004;
  EXPECT_NEAR(total, 0.5e6 * area - 9.81 * 7860.0 * area * 0.02, 1e-9);
}

TEST(ExternalForce, IsZeroWithoutLoads) {
  const Problem problem = build(cylinders);
  for (const ParticipantPart& part : participant_parts(problem, problem.scene.participants[0]))
    EXPECT_TRUE(ExternalForce(problem.scene.bodies[static_cast<std::size_t>(part.body)], part.part).zero());
}

}  // namespace
}  // namespace ricochet::scene
