#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <iterator>

#include "tests/support/graded_bar.hpp"

// `[mass_scaling]`: all_explicit in the step of the coarse elements, for which finer ones get heavier.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

std::string with_mass_scaling(const std::string& text, double step_s) {
  return text + "[mass_scaling]\nstep_s = " + std::to_string(1e9 * step_s) + "e-9\n";
}

/// Measured of the bar of `GradedBar` at 0.1 m/s, whose masses are scaled for the step of its largest element,
/// over what the bar has: 10 N for 2 ms, 0.02 N s.
struct ScaledImpact {
  GradedBar bar;
  double release, impulse;

  [[nodiscard]] std::string text() const {
    const double step_s = bar.step_s();
    std::string text = with_mass_scaling(bar.text("all_explicit", step_s), step_s);
    text.replace(text.find("[-1.0]"), 6, "[-0.1]").replace(text.find("end_s = 3e-3"), 12, "end_s = 6e-3");
    return text + "[output]\naxial_stress_every = 1\n";
  }
};

class MassScaling : public testing::TestWithParam<ScaledImpact> {};
INSTANTIATE_TEST_SUITE_P(Ratios, MassScaling,
                         testing::Values(ScaledImpact{{2, 150}, 1.385, 1.912}, ScaledImpact{{8, 270}, 1.85, 5.94},
                                         ScaledImpact{{32, 400}, 1.675, 21.5}),
                         [](const auto& tested) { return "r" + std::to_string(tested.param.bar.ratio); });

/// When half of the exact stress, 0.1 MPa, comes to the layer at the free end; `x` is its middle.
double arrival_s(const RunResult& run, double& x) {
  const History stress = read_history(run.folder + "/axial_stress.csv");
  const auto layer = std::prev(stress.end(), 3);  // by name, then the first layer and the time
  double begin = 0.0, end = 0.0;
  EXPECT_EQ(std::sscanf(layer->first.c_str(), "bar/%lf/%lf", &begin, &end), 2) << layer->first;
  x = 0.5 * (begin + end);
  std::size_t row = 0;
  while (row + 1 < layer->second.size() && std::abs(layer->second[row]) < 0.05e6) ++row;
  return stress.at("time_s")[row];
}

// Scaled to one step, an element of size h has rho A h_max^2 / h: a geometric grading by r makes the bar r times as
// heavy, its impedance at the fine end r times that of the material, and a wave takes h_max / c over every element.
TEST_P(MassScaling, MakesAnImpactOfTheFineEndLateAndHeavy) {
  const TemporaryFolder folder;
  const ScaledImpact& impact = GetParam();
  const RunResult run = run_text(impact.text(), folder);
  const double ratio = impact.bar.ratio, crossing_s = impact.bar.elements * impact.bar.step_s() / 0.9;
  EXPECT_NEAR(run.summary.at("added_mass_share").get<double>(), ratio - 1.0, 1e-6 * ratio);
  EXPECT_NEAR(run.summary.at("added_mass_kg").get<double>(), 0.1 * (ratio - 1.0), 1e-6 * ratio);
  EXPECT_THAT(run.outcome.out, HasSubstr("added mass"));
  EXPECT_THAT(run.outcome.error, HasSubstr("makes 1 element of body \"bar\" at the contact heavier"));
  EXPECT_NEAR(run.column("momentum_n_kg_m_s").front(), 0.01 * ratio, 1e-6 * ratio) << "of the scaled mass";
  EXPECT_NEAR(run.summary.at("first_window_force_n").get<double>(), 10.0 * ratio, 0.01 * 10.0 * ratio);
  double x = 0.0;
  const double arrived_s = arrival_s(run, x);
  EXPECT_NEAR(arrived_s, crossing_s - (1.0 - x) / 1000.0, 0.01 * crossing_s);
  EXPECT_NEAR(released_s(run), 2e-3 * impact.release, 0.01 * 2e-3 * impact.release);
  EXPECT_NEAR(run.last("contact_impulse_n_s"), 0.02 * impact.impulse, 0.01 * 0.02 * impact.impulse);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_LT(run.largest("energy_error"), 1e-9);
  EXPECT_GT(run.last("energy_error"), -0.01) << "the contact node's share";
}

TEST(MassScalingBaseline, IsAllExplicitWhereEveryElementBearsTheStep) {
  const TemporaryFolder a, b;
  const GradedBar bar{2, 100};
  const double step_s = 0.9 * 0.5 * bar.step_s();
  const auto with = run_text(with_mass_scaling(bar.text("all_explicit", step_s), step_s), a),
             without = run_text(bar.text("all_explicit", step_s), b);
  EXPECT_EQ(with.summary.at("added_mass_kg").get<double>(), 0.0);
  EXPECT_EQ(with.column("contact_force_n"), without.column("contact_force_n"));
  EXPECT_EQ(with.column("energy_strain_j"), without.column("energy_strain_j"));
}

TEST(MassScalingBaseline, KeepsTheBalancesOfTetrahedra) {
  const TemporaryFolder folder;
  const std::string text = with_protocol(with_absolute_meshes(config_text("ball_on_plate")), "all_explicit");
  const RunResult run = run_text(with_mass_scaling(with_key(text, "time", "end_s", "1e-5"), 6e-8), folder);
  EXPECT_GT(run.summary.at("added_mass_kg").get<double>(), 0.0);
  EXPECT_GT(run.last("contact_force_n"), 200.0);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_LT(run.largest("energy_error"), 1e-6);
}

}  // namespace
}  // namespace ricochet::test
