#include <gmock/gmock.h>

#include "tests/support/graded_bar.hpp"

// `local_explicit`: elements that the window is too long for take several steps in it.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

class LocalSteps : public testing::TestWithParam<GradedBar> {};
INSTANTIATE_TEST_SUITE_P(Ratios, LocalSteps, testing::Values(GradedBar{2, 150}, GradedBar{8, 270}, GradedBar{32, 400}),
                         [](const auto& tested) { return "r" + std::to_string(tested.param.ratio); });

TEST_P(LocalSteps, GiveAnImpactOfTheFineEndItsForceAndDuration) {
  const TemporaryFolder folder;
  const GradedBar& bar = GetParam();
  const RunResult run = run_text(bar.text("local_explicit", bar.step_s()), folder);
  EXPECT_THAT(run.outcome.error, testing::Not(HasSubstr("warning")));
  EXPECT_NEAR(released_s(run), 2e-3, 0.005 * 2e-3 + bar.step_s());
  EXPECT_NEAR(run.mean("contact_force_n", 0.3e-3, 1.7e-3), 100.0, 0.1);
  EXPECT_NEAR(run.last("momentum_n_kg_m_s"), -0.1, 0.01 * 0.1) << "rho A L v, turned round";
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_GT(run.last("energy_error"), -0.01) << "the contact node's share";
  EXPECT_LT(run.largest("energy_error"), 1e-9);
}

// Its planes of symmetry hold nodes that step locally: contact pulls at them inside the small steps.
TEST(LocalSteps, KeepTheMomentumOfTetrahedraWithSupportsAmongThem) {
  const TemporaryFolder folder;
  const std::string text = with_protocol(with_absolute_meshes(config_text("ball_on_plate")), "local_explicit");
  const RunResult run = run_text(with_key(text, "time", "end_s", "1e-5"), folder);
  EXPECT_GT(run.last("contact_force_n"), 200.0);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_LT(run.largest("energy_error"), 1e-6);
}

TEST(LocalSteps, AreThoseOfAllExplicitWhereEveryElementBearsTheStep) {
  const TemporaryFolder a, b;
  const GradedBar bar{2, 100};
  const double step_s = 0.9 * 0.5 * bar.step_s();
  const auto local = run_text(bar.text("local_explicit", step_s), a),
             all = run_text(bar.text("all_explicit", step_s), b);
  EXPECT_EQ(local.column("contact_force_n"), all.column("contact_force_n"));
  EXPECT_EQ(local.column("energy_strain_j"), all.column("energy_strain_j"));
}

}  // namespace
}  // namespace ricochet::test
