#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coupler/command/cost_text.hpp"
#include "tests/support/places.hpp"

namespace ricochet::coupler {
namespace {

scene::Scene scene_of(const std::string& config) {
  return scene::load_scene(test::source_folder() + "/configs/" + config + ".toml");
}

double end_of(const scene::Scene& scene) { return expected_end_s(scene::build_problem(scene)); }

TEST(CostText, EndsWithTheContactWhereTheoryKnowsIt) {
  auto scene = scene_of("kim_impact");
  EXPECT_NEAR(end_of(scene), 41.2e-6, 0.1e-6) << "2L/c, then 10 us";
  scene.time.until_separated_plus_s.reset();
  EXPECT_EQ(end_of(scene), 60e-6) << "the latest end";
  EXPECT_EQ(end_of(scene_of("two_balls")), 60e-6) << "curved: no theory";
}

TEST(CostText, SaysWhatThePredictionDoesNotKnow) {
  const auto text_of = [](const scene::Scene& scene) {
    const auto problem = scene::build_problem(scene);
    return cost_text(problem, scene::plan(problem));
  };
  const char* const earlier = "fewer steps if the bodies part before time.end_s";
  EXPECT_THAT(text_of(scene_of("two_balls")), testing::HasSubstr(earlier));
  auto flat = scene_of("kim_impact");
  EXPECT_THAT(text_of(flat),
              testing::Not(testing::AnyOf(testing::HasSubstr(earlier), testing::HasSubstr("iteration"))));
  flat.coupling.protocol = scene::protocol_traits("fixed_point");
  EXPECT_THAT(text_of(flat), testing::HasSubstr("with one iteration a step"));
  EXPECT_THAT(text_of(flat), testing::Not(testing::HasSubstr("yield")));
  auto yielding = scene_of("striker_gmsh");
  for (auto& body : yielding.bodies) body.material.plasticity = fem::Plasticity{1e9, 0.0};
  EXPECT_THAT(text_of(yielding), testing::HasSubstr("as if bodies that may yield did so in every step"));
}

TEST(CostText, SaysNothingOfTheTimeOfAProgramThatItDoesNotKnow) {
  auto scene = scene_of("two_bars");
  const auto text = [&] {
    const auto problem = scene::build_problem(scene);
    return cost_text(problem, scene::plan(problem));
  };
  EXPECT_THAT(text(), testing::AllOf(testing::HasSubstr("memory: about"), testing::HasSubstr("predicted: "),
                                     testing::HasSubstr("all_implicit would take"),
                                     testing::HasSubstr("all_explicit would take")));
  scene.participants.front().executable = "/usr/bin/true";
  EXPECT_THAT(text(),
              testing::AllOf(testing::HasSubstr("memory: about"), testing::Not(testing::HasSubstr("predicted"))));
}

/// A thousand rows, and fields of a megabyte each. The free space is given: a test cannot know that of its machine.
TEST(DiskText, AsksForFewerOfWhatTakesMost) {
  auto problem = scene::build_problem(scene_of("two_bars"));
  cost::PredictedCost cost;
  cost.windows = 1000.0;
  cost.field_files = 2.0;
  cost.field_bytes = 1e6;
  const auto text = [&](std::optional<double> free_bytes) { return disk_text(problem, cost, free_bytes); };
  EXPECT_THAT(text(1e12), testing::Not(testing::HasSubstr("warning"))) << "there is room";
  EXPECT_THAT(text(std::nullopt),
              testing::Not(testing::AnyOf(testing::HasSubstr("free"), testing::HasSubstr("warning"))));
  EXPECT_THAT(text(1e4), testing::HasSubstr("0.01 MB free here\nwarning: that is more than is free: fewer rows by a "
                                            "larger output.history_every"));
  problem.scene.output.fields_every = 10;
  EXPECT_THAT(text(1e4), testing::HasSubstr("fewer fields by a larger output.fields_every"));
}

}  // namespace
}  // namespace ricochet::coupler
