#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "common/scene/loaders.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/places.hpp"

namespace ricochet::scene {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

const std::string local_bars =
    replaced(bars, "end_s = 200e-6", "end_s = 200e-6\n[coupling]\nprotocol = \"local_explicit\"");
/// The contact end of the right bar is about a hundred times finer than the other.
const std::string graded_bars = replaced(local_bars, "start_m = 0.508e-3, length_m = 0.254, elements = 20",
                                         "start_m = 0.508e-3, length_m = 0.254, elements = 60, grading = 100.0");

Plan plan_with_local_steps(const std::string& text) { return plan(build_problem(load_text(text))); }

std::string refusal_of_local_steps(const std::string& text) {
  try {
    (void)plan_with_local_steps(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

/// "none" would be that of an implicit participant.
TEST(LocalStepsPlan, HasNoCriticalStepButLocalOnes) {
  const Problem problem = build_problem(load_text(graded_bars));
  EXPECT_THAT(to_text(problem, plan(problem)), testing::ContainsRegex("explicit +explicit .* local\n"));
}

TEST(LocalStepsPlan, SaysHowManyNodesTakeHowManySteps) {
  const Plan plan = plan_with_local_steps(graded_bars);
  ASSERT_EQ(plan.local_steps.size(), 2U);
  EXPECT_EQ(plan.local_steps[0].nodes, std::vector<int>{21});
  EXPECT_EQ(plan.local_steps[0].extra_rows, 0.0);
  const auto& nodes = plan.local_steps[1].nodes;
  EXPECT_GE(nodes.size(), 6U);
  int all = 0;
  for (const int n : nodes) all += n;
  EXPECT_EQ(all, 61);
  EXPECT_THAT(plan.notes, Contains(AllOf(HasSubstr("local steps of body \"right\": of 61 nodes"), HasSubstr("take 32"),
                                         HasSubstr("products with all of its stiffness"))));
  EXPECT_TRUE(plan.warnings.empty());
}

/// A body that flies against a support of its own, too.
TEST(LocalStepsPlan, WarnsOfASupportThatStopsSmallStepsAtOnce) {
  const std::string alone =
      replaced(replaced(graded_bars, ", right = 0.0635", ""), "surfaces = [\"left.end\", \"right.start\"]",
               "surfaces = [\"left.start\", \"rigid_plane\"]");
  const std::string held =
      replaced(alone, "grading = 100.0 }", "grading = 100.0 }\nsupport = [{ surface = \"start\", fixed = [\"x\"] }]");
  EXPECT_TRUE(plan_with_local_steps(alone).warnings.empty());
  EXPECT_THAT(plan_with_local_steps(held).warnings,
              Contains(AllOf(HasSubstr("body \"right\" jumps by"), HasSubstr("several steps in a window"))));
}

TEST(LocalStepsPlan, AllowsAStepThatItTakes) {
  Scene scene = load_scene(test::source_folder() + "/configs/two_balls.toml");
  scene.coupling.protocol = protocol_traits("local_explicit");
  scene.participants = participants_of(scene, {});
  const auto refusal_of = [&scene](double step_s) -> std::string {
    scene.time.step_s = step_s;
    try {
      (void)plan(build_problem(scene));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string error = refusal_of(3e-5), allowed = "allowed with \"local_explicit\": ";
  ASSERT_THAT(error, HasSubstr(allowed));
  const double step_s = std::stod(error.substr(error.find(allowed) + allowed.size()));
  EXPECT_GT(step_s, 2e-7);
  EXPECT_EQ(refusal_of(step_s), "accepted");
}

TEST(LocalStepsPlan, RefusesWhatItCannotDoByName) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrong = {
      {replaced(graded_bars, "step_s = 2.226e-6\n", ""), {"time", "no step_s, which \"local_explicit\" needs"}},
      {replaced(graded_bars, "step_s = 2.226e-6", "step_s = 1e-4"),
       {"time.step_s", "too long for every element", "or less"}},
      {replaced(graded_bars, "step_s = 2.226e-6", "step_s = 1.9e-4"), {"time.step_s", "too long for every element"}},
      {replaced(graded_bars, "end_s = 200e-6", "changes = [{ from_s = 1e-5, step_s = 1e-6 }]\nend_s = 200e-6"),
       {"changes", "under \"local_explicit\"", "\"all_explicit\""}},
      {replaced(graded_bars, "surfaces", "enforcement = \"penalty\"\npenalty_pa_m = 1e13\nsurfaces"),
       {"contact.enforcement", "\"penalty\" under \"local_explicit\"", "\"multiplier\""}},
      {replaced(graded_bars, "surfaces", "multiplier_update = \"massless\"\nsurfaces"),
       {"contact.multiplier_update", "\"massless\" under \"local_explicit\""}},
      {replaced(replaced(replaced(graded_bars, ", right = 0.0635", ""), "surfaces = [\"left.end\", \"right.start\"]",
                         "surfaces = [\"left.start\", \"rigid_plane\"]"),
                "grading = 100.0 }", "grading = 100.0 }\nabsorbing = [{ surface = \"start\" }]"),
       {"time.step_s", "absorbing surface of body \"right\"", "several steps in a window"}},
  };
  for (const auto& [text, parts] : wrong)
    for (const auto& part : parts) EXPECT_THAT(refusal_of_local_steps(text), HasSubstr(part)) << text;
}

}  // namespace
}  // namespace ricochet::scene
