// Prescribed motion against an exact wave, and the energy watch that must let it pass: a bar at rest, one end of which
// moves with a constant velocity V from t_0 on. Behind the front that runs from there everything moves with V, under
// the strain V/c: momentum rho A c V (t - t_0), work rho A c V^2 (t - t_0), half of it kinetic.
#include <gmock/gmock.h>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr double velocity_m_s = 1e-3, begin_s = 0.3, end_s = 1.2;  // the front is at 0.9 of the bar then

/// E = rho = A = L = 1. Elements from 4.6 mm at the low end to 18.4 mm at the high one; those that the step is too long
/// for are implicit.
std::string bar(const std::string& protocol, const std::string& moved_end, double step_s) {
  return R"(model = "bar"
[[body]]
name = "bar"
material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }
mesh = { length_m = 1.0, elements = 100, grading = 4.0 }
[[body.prescribed]]
surface = ")" +
         moved_end + R"("
component = "x"
displacement_m = 1e-3
amplitude = { time_s = [0.3, 1.3], factor = [0.0, 1.0] }
[time]
step_s = )" +
         std::to_string(step_s) + R"(
end_s = 1.2
[coupling]
protocol = ")" +
         protocol + R"("
[output]
history_every = 1
)";
}

class PrescribedMotion : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(PrescribedMotion, MakesTheExactWave) {
  const auto& [protocol, moved_end] = GetParam();
  const TemporaryFolder folder;
  const auto run = run_text(bar(protocol, moved_end, protocol == "all_explicit" ? 0.004 : 0.008), folder);
  const double passed_s = run.last("time_s") - begin_s, work_j = velocity_m_s * velocity_m_s * passed_s;
  ASSERT_GT(passed_s, end_s - begin_s - 0.01);
  EXPECT_NEAR(run.last("velocity_mean_bar_m_s"), velocity_m_s * passed_s, 5e-3 * velocity_m_s * passed_s);
  EXPECT_NEAR(run.last("energy_external_j"), work_j, 1e-2 * work_j);
  EXPECT_NEAR(run.last("energy_kinetic_j"), 0.5 * work_j, 2e-2 * work_j);
  EXPECT_NEAR(run.last("energy_strain_j"), 0.5 * work_j, 2e-2 * work_j);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), protocol.rfind("kim", 0) == 0 ? 3e-3 : 1e-8);
}

INSTANTIATE_TEST_SUITE_P(EveryProtocol, PrescribedMotion,
                         testing::Combine(testing::Values("hughes_liu", "kim", "kim_predicted", "belytschko_mullen",
                                                          "prakash_hjelmstad", "gravouil_combescure", "fixed_point",
                                                          "all_implicit", "all_explicit"),
                                          testing::Values("start", "end")),  // implicit end, explicit end
                         [](const auto& test) { return std::get<0>(test.param) + "_" + std::get<1>(test.param); });

TEST(EnergyWatchInARun, HistoryEveryChangesNoVerdict) {
  const TemporaryFolder folder;
  std::string text =
      replaced(with_protocol(config_text("two_bars"), "kim_predicted"), "end_s = 250e-6", "end_s = 5e-3");
  text = with_key(text, "coupling", "after_separation", "\"implicit\"");
  std::string first;
  for (const char* rows : {"1", "3", "1000"}) {
    const auto run = run_file(folder.write(with_key(text, "output", "history_every", rows)), folder, rows);
    EXPECT_EQ(run.outcome.code, 3) << rows;
    const auto error = run.summary.at("error").get<std::string>();
    EXPECT_THAT(error, HasSubstr("unstable in window "));
    if (first.empty()) first = error;
    EXPECT_EQ(error, first) << rows;
    const auto& time = run.column("time_s");
    if (time.size() > 1) {
      EXPECT_NEAR(time[1], std::stod(rows) * 2.226e-6, 1e-12);
    }
  }
}

}  // namespace
}  // namespace ricochet::test
