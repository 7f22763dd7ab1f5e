#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "tests/common/scene/scene_text.hpp"

namespace ricochet::scene {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// The contact end of the right bar is ten times finer than the other, and every element is to bear the step of its
/// coarsest.
const std::string graded_and_explicit =
    replaced(replaced(bars, "start_m = 0.508e-3, length_m = 0.254, elements = 20",
                      "start_m = 0.508e-3, length_m = 0.254, elements = 60, grading = 10.0"),
             "step_s = 2.226e-6\n", "") +
    "[coupling]\nprotocol = \"all_explicit\"\n";
const std::string heavy_bars = graded_and_explicit + "[mass_scaling]\nstep_s = 1.5e-6\n";

Plan scaled_plan(const std::string& text) { return plan(build_problem(load_text(text))); }

std::string refusal_of_scaling(const std::string& text) {
  try {
    (void)scaled_plan(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MassScalingPlan, SaysHowManyElementsGetHowMuchMassAndAtWhichContact) {
  const Plan heavier = scaled_plan(heavy_bars), lighter = scaled_plan(graded_and_explicit);
  double mass_kg = 0.0, own_kg = 0.0;
  for (std::size_t b = 0; b < 2; ++b) {
    mass_kg += heavier.bodies[b].mass_kg;
    own_kg += lighter.bodies[b].mass_kg;
    EXPECT_NEAR(heavier.bodies[b].volume_m3, lighter.bodies[b].volume_m3, 1e-12 * lighter.bodies[b].volume_m3);
  }
  EXPECT_NEAR(heavier.added_mass_kg, mass_kg - own_kg, 1e-12 * mass_kg);
  EXPECT_NEAR(heavier.added_mass_share, mass_kg / own_kg - 1.0, 1e-12);
  EXPECT_GT(heavier.added_mass_share, 0.1);
  EXPECT_EQ(heavier.bodies[0].mass_kg, lighter.bodies[0].mass_kg) << "coarse enough";
  EXPECT_THAT(heavier.notes, Contains(AllOf(HasSubstr("mass scaling of body \"right\""), HasSubstr("of 60 elements"),
                                            HasSubstr("times their density"), HasSubstr("%) more in all"))));
  EXPECT_THAT(heavier.notes, Not(Contains(HasSubstr("mass scaling of body \"left\""))));
  EXPECT_THAT(heavier.warnings, Contains(HasSubstr("makes 1 element of body \"right\" at the contact heavier")));
}

TEST(MassScalingPlan, LetsTheStepBeTaken) {
  const Problem problem = build_problem(load_text(heavy_bars));
  const Plan heavier = plan(problem);
  EXPECT_EQ(problem.clock.size_s(), 1.5e-6) << "which it is for, as none is given";
  EXPECT_GE(critical_time_step(heavier.participants), 1.5e-6 / 0.9);
  EXPECT_NEAR(element_bound_time_step(problem, problem.scene.participants.front()), 1.5e-6 / 0.9, 1e-15);
  EXPECT_LT(critical_time_step(scaled_plan(graded_and_explicit).participants), 0.5e-6);
}

TEST(MassScalingPlan, AddsNothingWhereEveryElementBearsTheStep) {
  const Plan plan = scaled_plan(graded_and_explicit + "[mass_scaling]\nstep_s = 1e-7\n");
  EXPECT_EQ(plan.added_mass_kg, 0.0);
  EXPECT_THAT(plan.notes, Contains(HasSubstr("mass scaling adds nothing")));
  EXPECT_TRUE(plan.warnings.empty());
}

TEST(MassScalingPlan, RefusesWhatItCannotDoByName) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrong = {
      {replaced(heavy_bars, "all_explicit", "local_explicit"),
       {"mass_scaling", "under \"local_explicit\"", "\"all_explicit\""}},
      {replaced(heavy_bars, "all_explicit", "all_implicit"), {"mass_scaling", "under \"all_implicit\""}},
      {replaced(heavy_bars, "all_explicit", "hughes_liu"), {"mass_scaling", "under \"hughes_liu\""}},
      {replaced(heavy_bars, "step_s = 1.5e-6", "step_s = 0"), {"mass_scaling.step_s"}},
      {replaced(heavy_bars, "step_s = 1.5e-6", ""), {"mass_scaling.step_s"}},
      {replaced(heavy_bars, "[time]\n", "[time]\nstep_s = 2.2e-6\n"), {"time.step_s", "the critical time step"}},
      {heavy_bars + "[[participant]]\nname = \"e\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\nexecutable = "
                    "\"./mine\"\n",
       {"executable", "mine", "under [mass_scaling]", "the shipped solver"}},
  };
  for (const auto& [text, parts] : wrong)
    for (const auto& part : parts) EXPECT_THAT(refusal_of_scaling(text), HasSubstr(part)) << text;
}

}  // namespace
}  // namespace ricochet::scene
