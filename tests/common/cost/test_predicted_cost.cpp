#include <gtest/gtest.h>

#include "common/cost/predicted_cost.hpp"
#include "tests/support/places.hpp"

namespace ricochet::cost {
namespace {

scene::Scene scene_of(const std::string& config) {
  return scene::load_scene(test::source_folder() + "/configs/" + config + ".toml");
}

/// On a machine as fast as the one whose figures the prediction has.
PredictedCost cost_of(const scene::Scene& scene) {
  const auto problem = scene::build_problem(scene);
  return predict_cost(problem, scene::plan(problem), scene.time.end_s, {1.0, 2});
}

TEST(PredictedCost, GrowsWithTheMesh) {
  auto scene = scene_of("kim_impact");
  const PredictedCost coarse = cost_of(scene);
  for (auto& body : scene.bodies) {
    auto& mesh = std::get<scene::StructuredMesh>(body.pieces.front().elements);
    mesh.elements_along *= 4;
    mesh.elements_across *= 4;
  }
  scene.time.step_s = *scene.time.step_s / 4;
  const PredictedCost fine = cost_of(scene);
  EXPECT_NEAR(fine.windows, 4 * coarse.windows, 4);
  // Sixteen times the unknowns; of the factor more than that.
  EXPECT_GT(fine.all_explicit_s / coarse.all_explicit_s, 4 * 5);
  EXPECT_GT(fine.all_implicit_s / coarse.all_implicit_s, 4 * 16);
  EXPECT_GT(fine.window_s, 5 * coarse.window_s);
  EXPECT_GT(fine.factor_bytes, 16 * coarse.factor_bytes);
}

TEST(PredictedCost, KnowsTheStepOfAllExplicitAndWhatMovesFromTheStart) {
  auto scene = scene_of("rounded_striker");
  const PredictedCost cost = cost_of(scene);
  EXPECT_NEAR(cost.all_explicit_step_s, 0.9 * 1.787e-9, 2e-12) << "of the smallest element";
  EXPECT_GT(cost.all_explicit_s, 5 * cost.stepping_s()) << "what hybrid is for";

  auto bars = scene_of("two_bars");
  bars.time.end_s = 20e-6;  // the waves get through a fraction of the bars
  const double flies = cost_of(bars).all_explicit_s;
  bars.bodies[0].gravity_m_s2 = bars.bodies[1].gravity_m_s2 = {1.0};
  EXPECT_GE(cost_of(bars).all_explicit_s, flies) << "gravity moves all of it";
}

/// The price of yield and turn in docs/limits.md. The time of an explicit step is measured here and now, and not
/// compared.
TEST(PredictedCost, CountsTheSolvesOfBodiesThatYieldOrTurn) {
  const PredictedCost linear = cost_of(scene_of("rounded_striker"));
  auto yielding = scene_of("rounded_striker");
  for (auto& body : yielding.bodies) body.material.plasticity = fem::Plasticity{2e9, 1e10};
  const PredictedCost yields = cost_of(yielding);
  EXPECT_GT(yields.all_implicit_s, 5 * linear.all_implicit_s);
  EXPECT_GT(yields.local_explicit_s, 0.0);
  auto turning = scene_of("oblique_ball");
  const PredictedCost still = cost_of(turning);
  for (auto& body : turning.bodies) body.large_rotation = true;
  const PredictedCost turns = cost_of(turning);
  EXPECT_GT(turns.all_implicit_s, 2.5 * still.all_implicit_s);
  EXPECT_GT(turns.local_explicit_s, 0.0);
}

TEST(PredictedCost, TakesAllExplicitWithScaledMassesInTheirStep) {
  auto scene = scene_of("rounded_striker");
  scene.coupling.protocol = scene::protocol_traits("all_explicit");
  scene.participants.assign(1, {});
  scene.participants.front().name = "explicit";
  scene.participants.front().bodies = scene.body_names();
  scene.time.step_s = scene.mass_scaling_step_s = 1e-8;
  auto in_own_step = scene;
  in_own_step.mass_scaling_step_s.reset();
  in_own_step.time.step_s = 0.9 * 1.78e-9;
  // Each prediction times K u when it is made: a busy machine may slow one of two.
  constexpr int tries = 5;
  bool a_quarter = false;
  for (int i = 0; i < tries && !a_quarter; ++i) {
    const PredictedCost scaled = cost_of(scene), own = cost_of(in_own_step);
    EXPECT_EQ(scaled.all_explicit_step_s, 1e-8);
    EXPECT_EQ(scaled.all_explicit_s, scaled.stepping_s());
    EXPECT_NEAR(own.windows / scaled.windows, 1e-8 / (0.9 * 1.78e-9), 0.01);
    a_quarter = own.stepping_s() > 4 * scaled.stepping_s();
  }
  EXPECT_TRUE(a_quarter);
}

TEST(PredictedCost, CountsRowsThatAreWrittenAnew) {
  auto scene = scene_of("two_balls_solid");
  for (auto& body : scene.bodies) body.supports.clear();
  const PredictedCost straight = cost_of(scene);
  scene.bodies.front().initial_velocity_m_s.front() = 10.0;
  const PredictedCost oblique = cost_of(scene);
  EXPECT_GT(oblique.all_implicit_s, 1.1 * straight.all_implicit_s);
  EXPECT_GT(oblique.all_explicit_s, 1.1 * straight.all_explicit_s);
  EXPECT_GT(oblique.stepping_s(), 1.1 * straight.stepping_s());
}

TEST(PredictedCost, IsMeasuredInUnitsOfThisMachine) {
  const auto problem = scene::build_problem(scene_of("two_bars"));
  const auto plan = scene::plan(problem);
  const double here = predict_cost(problem, plan, problem.scene.time.end_s, {1.0, 2}).stepping_s();
  EXPECT_GT(predict_cost(problem, plan, problem.scene.time.end_s, {10.0, 2}).stepping_s(), 5 * here);
  EXPECT_GE(predict_cost(problem, plan, problem.scene.time.end_s, {1.0, 1}).stepping_s(), here)
      << "explicit and implicit side in turns";
  EXPECT_GT(measure_speed().slowness, 0.0);
}

}  // namespace
}  // namespace ricochet::cost
