#include <gmock/gmock.h>

#include <algorithm>
#include <deque>
#include <numeric>

#include "common/base/error.hpp"
#include "common/base/read_file.hpp"
#include "common/check/check.hpp"
#include "common/check/check_islands.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/places.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::scene {
namespace {

using testing::HasSubstr;

/// Implicit elements of a body that no walk from a contact node over implicit elements comes to.
std::vector<int> not_reached(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  std::vector<std::vector<int>> of_node(body.mesh.position.size());
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e)
    for (const int node : body.mesh.elements[at(e)])
      if (body.implicit_element[at(e)]) of_node[at(node)].push_back(e);
  std::vector<bool> reached(body.mesh.elements.size(), false);
  const auto nodes = contact_nodes(problem.contacts, index);
  std::deque<int> open(nodes.begin(), nodes.end());
  while (!open.empty()) {
    const int node = open.front();
    open.pop_front();
    for (const int e : of_node[at(node)]) {
      if (reached[at(e)]) continue;
      reached[at(e)] = true;
      for (const int next : body.mesh.elements[at(e)]) open.push_back(next);
    }
  }
  std::vector<int> left;
  for (int e = 0; e < static_cast<int>(reached.size()); ++e)
    if (body.implicit_element[at(e)] && !reached[at(e)]) left.push_back(e);
  return left;
}

/// In windows that are too long for some elements far from the contact, whatever their neighbours.
Problem ball_on_plate(const std::string& protocol) {
  std::string text = read_file(test::source_folder() + "/configs/ball_on_plate.toml");
  for (std::size_t at = 0; (at = text.find("gmsh = \"", at)) != std::string::npos; at += 8)
    text.insert(at + 8, test::source_folder() + "/configs/");
  text = replaced(text, "step_s = 6e-8", "step_s = 1.2e-7");
  return build_problem(load_text(text + "[coupling]\nprotocol = \"" + protocol + "\"\n"));
}

/// In a mesh of Gmsh, under a dual protocol, whose explicit side has no small steps.
TEST(Islands, AreTheImplicitElementsThatHangOnNoContact) {
  const auto problem = ball_on_plate("prakash_hjelmstad");
  const auto all = islands_of(problem);
  ASSERT_EQ(all.size(), 2U);
  for (const Islands& islands : all) {
    const auto elements = not_reached(problem, islands.body);
    EXPECT_EQ(std::accumulate(islands.elements.begin(), islands.elements.end(), 0), static_cast<int>(elements.size()));
    EXPECT_GT(islands.elements.size(), 1U);
    EXPECT_EQ(islands.slivers, std::count_if(islands.elements.begin(), islands.elements.end(),
                                             [](int elements) { return elements < 10; }));
    ASSERT_EQ(islands.shortest.size(), 5U);
    EXPECT_TRUE(std::is_sorted(islands.shortest_s.begin(), islands.shortest_s.end()));
    EXPECT_LT(islands.shortest_s.back(), problem.clock.size_s());
    for (const int e : islands.shortest) EXPECT_THAT(elements, testing::Contains(e));
    EXPECT_THAT(to_text(problem, plan(problem)), HasSubstr("note: " + text_of(problem, islands)));
    EXPECT_THAT(text_of(problem, islands),
                HasSubstr("of them have fewer than 10 elements: mend these, or take a primal "
                          "protocol, whose explicit side takes small steps there"));
  }
}

/// A primal protocol gives them back to the explicit side, but for those with a node of an absorbing surface.
TEST(Islands, AreSteppedByTheExplicitSideWhereItCan) {
  const auto before = ball_on_plate("prakash_hjelmstad"), after = ball_on_plate("hughes_liu");
  const auto left = islands_of(after);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(after.bodies[at(left[0].body)].name, "plate");
  int released = 0, kept = 0;
  for (std::size_t b = 0; b < after.bodies.size(); ++b) {
    const BodyProblem& body = after.bodies[b];
    for (std::size_t e = 0; e < body.mesh.elements.size(); ++e) {
      if (!before.bodies[b].implicit_element[e]) {
        EXPECT_FALSE(body.implicit_element[e] || (!body.small_steps.empty() && body.small_steps[e]));
        continue;
      }
      const bool small = !body.small_steps.empty() && body.small_steps[e];
      EXPECT_NE(body.implicit_element[e], small);
      (small ? released : kept) += 1;
    }
  }
  const auto elements_of = [](const std::vector<Islands>& all) {
    int sum = 0;
    for (const Islands& islands : all) sum = std::accumulate(islands.elements.begin(), islands.elements.end(), sum);
    return sum;
  };
  EXPECT_EQ(released + elements_of(left), elements_of(islands_of(before)));
  EXPECT_GT(released, 50);
  EXPECT_GT(kept, 8000) << "what is fine at the contact";
}

/// A shared node that is too stiff for the window bears none, however finely its neighbours step.
TEST(Islands, ThatReachWhatIsSharedAreRefused) {
  Problem problem = ball_on_plate("hughes_liu");
  for (int index = 0; index < 2; ++index) {
    BodyProblem& body = problem.bodies[at(index)];
    body.implicit_element = elements_at(body.mesh, contact_nodes(problem.contacts, index));
    body.implicit_node = touched_nodes(body, body.implicit_element);
    body.small_steps = body.implicit_element;
    body.small_steps.flip();
  }
  try {
    static_cast<void>(plan(problem));
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("time.step_s: found 1.2e-07 s, in which elements of body \"ball\" take no small "
                          "steps: local steps: no levels were found that bear the window; allowed: a "
                          "smaller step, or partition.implicit_length_m in place of rule = \"auto\""));
  }
}

/// The right bar with 60 elements that grow by this along it.
std::string bars_with(const std::string& grading) {
  const std::string graded = replaced(bars, "start_m = 0.508e-3, length_m = 0.254, elements = 20",
                                      "start_m = 0.508e-3, length_m = 0.254, elements = 60, grading = " + grading);
  return replaced(graded, "implicit_length_m = { left = 0.0635, right = 0.0635 }", "rule = \"auto\"");
}

/// A zone that is fine on purpose is one island; at the contact it is none.
TEST(Islands, OfAFineZoneAreRightToBeImplicit) {
  EXPECT_TRUE(islands_of(build_problem(load_text(bars_with("100.0")))).empty());
  const auto far = build_problem(load_text(bars_with("0.01")));
  const auto islands = islands_of(far);
  ASSERT_EQ(islands.size(), 1U);
  EXPECT_EQ(islands[0].elements.size(), 1U);
  EXPECT_EQ(islands[0].slivers, 0);
  EXPECT_EQ(islands[0].shared_nodes, 1);
  EXPECT_THAT(text_of(far, islands[0]), HasSubstr("right to be implicit"));
}

/// A fine zone does not hide the bad element beside it.
TEST(Islands, AreJudgedOneByOne) {
  auto problem = build_problem(load_text(bars_with("0.01")));
  const auto zone = islands_of(problem);
  ASSERT_EQ(zone.size(), 1U);
  BodyProblem& body = problem.bodies[at(zone[0].body)];
  const auto bad = std::find(body.implicit_element.begin(), body.implicit_element.end(), false) + 2;
  ASSERT_FALSE(*(bad - 1) || *bad || *(bad + 1));
  *bad = true;
  const auto islands = islands_of(problem);
  ASSERT_EQ(islands[0].elements.size(), 2U);
  EXPECT_EQ(islands[0].slivers, 1);
  EXPECT_THAT(islands[0].shortest, testing::ElementsAre(static_cast<int>(bad - body.implicit_element.begin())));
  EXPECT_THAT(text_of(problem, islands[0]), HasSubstr("1 of them has fewer than 10 elements"));
}

/// The partition asks elements for the longest window of all, however short the last one is.
TEST(Islands, AreOfTheStepThatThePartitionAsksFor) {
  const auto problem = build_problem(
      load_text(replaced(bars_with("0.01"), "[time]", "[time]\nchanges = [{ from_s = 8e-5, step_s = 1e-6 }]")));
  EXPECT_EQ(problem.clock.size_s(), 1e-6);
  const auto islands = islands_of(problem);
  ASSERT_EQ(islands.size(), 1U);
  EXPECT_EQ(islands[0].step_s, 2.226e-6);
}

TEST(Islands, AreNoneWhereTheSceneSaysWhatIsImplicit) {
  EXPECT_TRUE(islands_of(build_problem(load_text(bars))).empty());
  const std::string whole = bars_with("100.0") + "[coupling]\nprotocol = \"all_implicit\"\n";
  EXPECT_TRUE(islands_of(build_problem(load_text(whole))).empty());
}

}  // namespace
}  // namespace ricochet::scene
