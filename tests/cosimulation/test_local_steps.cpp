#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <utility>

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

/// A contact inside small steps is in the elements: the book of contact has what is gone, not what is stored.
TEST(LocalSteps, BookWhatContactCosts) {
  const TemporaryFolder folder;
  const std::string text =
      replaced(with_absolute_meshes(config_text("two_balls")), "[partition]\nrule = \"auto\"\n", "");
  const RunResult run = run_text(with_protocol(text, "local_explicit"), folder);
  const double first = run.column("energy_kinetic_j").front();
  for (std::size_t n = 0; n < run.column("time_s").size(); ++n) {
    const auto at = [&](const char* name) { return run.column(name)[n]; };
    ASSERT_NEAR((at("energy_kinetic_j") + at("energy_strain_j") - at("energy_contact_j")) / first, 1.0, 1e-12) << n;
    ASSERT_NEAR(at("energy_contact_j") / first, 0.0, 1e-4) << n;
  }
}

/// A load on the fine end does f . du, and what it gives is in the bar.
TEST(LocalSteps, BookTheWorkOfLoadsInsideThem) {
  const TemporaryFolder folder;
  const GradedBar bar{16, 300};
  std::string text = replaced(bar.text("local_explicit", bar.step_s()),
                              "[contact]\nsurfaces = [\"bar.start\", \"rigid_plane\"]\n", "");
  text =
      replaced(text, "initial_velocity_m_s = [-1.0]",
               "traction = [{ surface = \"start\", traction_pa = [1e6], amplitude = { time_s = [0.0, 5e-4], factor = "
               "[0.0, 1.0] } }]");
  const RunResult run = run_text(replaced(text, "end_s = 3e-3", "end_s = 5e-4"), folder);
  EXPECT_GT(run.last("energy_external_j"), 0.0);
  EXPECT_LT(std::abs(run.last("energy_error")), 5e-4);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
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

/// A bar at rest whose fine end, its finest element `ratio` times shorter than the other end's, is pushed in by 20 m/s
/// at once, or within 20 us. Behind the front stress is rho c v.
struct PushedBar {
  int ratio, elements;
  bool at_once;

  [[nodiscard]] std::string text(const std::string& protocol) const {
    const GradedBar bar{ratio, elements};
    std::string pushed = "time_s = [0.0, 2e-4], factor = [0.0, 1.0]";
    if (!at_once) {
      std::string times = "0.0", factors = "0.0";
      for (int i = 1; i <= 20; ++i) {
        times += fmt::format(", {}", i * 1e-6);
        factors += fmt::format(", {}", 0.05 * (i / 20.0) * (i / 20.0));
      }
      pushed = fmt::format("time_s = [{}, 2e-4], factor = [{}, 0.95]", times, factors);
    }
    std::string text = replaced(bar.text(protocol, bar.step_s() / (protocol == "all_explicit" ? 5.0 * ratio : 5.0)),
                                "[contact]\nsurfaces = [\"bar.start\", \"rigid_plane\"]\n", "");
    text = replaced(text, "youngs_modulus_pa = 1e9", "youngs_modulus_pa = 25e9");  // c = 5000 m/s
    text = replaced(text, "end_s = 3e-3", "end_s = 150e-6");
    text = replaced(text, "initial_velocity_m_s = [-1.0]",
                    "prescribed = [{ surface = \"start\", component = \"x\", displacement_m = 4e-3, amplitude = { " +
                        pushed + " } }]");
    return text + "[[output.probe]]\nname = \"near\"\nbody = \"bar\"\nat_m = [0.0005]\n";
  }
  /// Standard deviation of the stress near the pushed end over its mean, from 50 us on, and that mean over rho c v.
  [[nodiscard]] std::pair<double, double> ringing(const std::string& protocol, const TemporaryFolder& folder) const {
    const RunResult run = run_text(text(protocol), folder, protocol + (at_once ? "_at_once" : "_ramp"));
    const History probes = read_history(run.folder + "/probes.csv");
    double sum = 0.0, squares = 0.0, n = 0.0;
    for (std::size_t i = 0; i < probes.at("time_s").size(); ++i) {
      if (probes.at("time_s")[i] < 50e-6) continue;
      const double stress = probes.at("near.stress_xx_pa")[i] / -(1000.0 * 5000.0 * 20.0);
      sum += stress;
      squares += stress * stress;
      n += 1.0;
    }
    return {std::sqrt(squares / n - sum / n * sum / n) / (sum / n), sum / n};
  }
};

TEST(LocalSteps, RingWhereAHeldNodeAmongThemTakesAVelocityAtOnce) {
  const TemporaryFolder folder;
  const PushedBar at_once{4, 200, true}, ramp{4, 200, false};
  const auto [local, mean] = at_once.ringing("local_explicit", folder);
  EXPECT_GT(local, 0.15);
  EXPECT_NEAR(mean, 1.0, 0.01) << "it rings about the right stress";
  EXPECT_LT(at_once.ringing("all_explicit", folder).first, 0.06);
  EXPECT_LT(ramp.ringing("local_explicit", folder).first, 0.02);
  const auto warned = [&](const PushedBar& bar) {
    return run_command({ricochet_binary(), "check", folder.write(bar.text("local_explicit"))}, folder.path().string());
  };
  EXPECT_THAT(warned(at_once).error + warned(at_once).out,
              HasSubstr("the velocity of body \"bar\" jumps by 20 m/s at the held node at"));
  EXPECT_THAT(warned(ramp).error + warned(ramp).out, testing::Not(HasSubstr("jumps")));
}

TEST(LocalSteps, StopTheRunWhereAFinerBarIsPushedInAtOnce) {
  const TemporaryFolder folder;
  const auto outcome =
      run_command({ricochet_binary(), "run", folder.write(PushedBar{16, 300, true}.text("local_explicit"))},
                  folder.path().string());
  EXPECT_EQ(outcome.code, 3) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("energy balance has grown"));
}

}  // namespace
}  // namespace ricochet::test
