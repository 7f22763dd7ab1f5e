// Elements whose force is not linear in their displacement, behind the seam InternalForce: a mass on a spring of the
// force k u + k3 u^3, which is the explicit element of a bar, while the implicit one next to it is a thousandth as long
// and so all but rigid.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

constexpr double stiffening = 1e5;  ///< b of the program: N = E A (strain + b strain^3)
constexpr double speed_m_s = 0.01, short_element_m = 0.001;
constexpr double mass_kg = 0.5 + short_element_m;  ///< half of the long element and the short one

/// Amplitude and a quarter of the period. From M v^2/2 + u^2/2 + b u^4/4 = M V^2/2, with u = A sin(theta):
///   T/4 = integral_0^(pi/2) sqrt(M / (1 + b A^2 (1 + sin^2 theta)/2)) d theta
/// The integrand is periodic, so that the trapezoidal rule leaves nothing but round-off.
double quarter_period_s() {
  const double square = (std::sqrt(1.0 + 2.0 * stiffening * mass_kg * speed_m_s * speed_m_s) - 1.0) / stiffening;
  constexpr int points = 64;
  double sum = 0.0;
  for (int i = 0; i <= points; ++i) {
    const double sine = std::sin(0.5 * M_PI * i / points), end = i == 0 || i == points ? 0.5 : 1.0;
    sum += end * std::sqrt(mass_kg / (1.0 + 0.5 * stiffening * square * (1.0 + sine * sine)));
  }
  return sum * 0.5 * M_PI / points;
}

std::string scene_with(const std::string& protocol, int windows, const std::string& more = "") {
  const std::string cubic =
      fmt::format("executable = \"{}/cubic_participant\"\ndiffering_bodies = [\"rod\"]\n", RICOCHET_BUILD);
  const std::string implicit =
      protocol == "all_explicit" ? "" : "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  return fmt::format(R"(model = "bar"
[[body]]
name = "rod"
material = {{ youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }}
mesh = {{ length_m = {:.17g}, elements = 2, grading = {} }}
support = [{{ surface = "start", fixed = ["x"] }}]
initial_velocity_m_s = [{}]
[time]
step_s = {:.17g}
end_s = {:.17g}
[coupling]
protocol = "{}"
{}[[participant]]
name = "explicit"
role = "explicit"
bodies = ["rod"]
{}{})",
                     1.0 + short_element_m, short_element_m, speed_m_s, 8.0 * quarter_period_s() / windows,
                     8.0 * quarter_period_s(), protocol, more, cubic, implicit);
}

/// When the mass comes to rest for the third time.
double third_rest_s(const RunResult& run) {
  const auto &time = run.column("time_s"), &momentum = run.column("momentum_n_kg_m_s");
  int found = 0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (momentum[i - 1] * momentum[i] > 0.0 || momentum[i] == 0.0) continue;
    if (++found == 3) return time[i - 1] + (time[i] - time[i - 1]) * momentum[i - 1] / (momentum[i - 1] - momentum[i]);
  }
  ADD_FAILURE() << "it rests " << found << " times";
  return 0.0;
}

struct Method {
  const char* protocol;
  int substeps, windows;  ///< of two cycles
};

class CubicBars : public testing::TestWithParam<Method> {};

TEST_P(CubicBars, SwingAsTheQuadratureOfTheirEnergySays) {
  const auto& [protocol, substeps, windows] = GetParam();
  const std::string more = substeps > 1 ? fmt::format("substeps = {}\n", substeps) : "";
  const TemporaryFolder folder;
  double error[2];
  for (const int k : {0, 1}) {
    const RunResult run = run_text(scene_with(protocol, windows << k, more), folder, fmt::format("windows{}", k));
    error[k] = third_rest_s(run) / (5.0 * quarter_period_s()) - 1.0;
    for (const double e : run.column("energy_error")) EXPECT_LT(std::abs(e), 5e-3);
  }
  EXPECT_LT(std::abs(error[0]), 2e-3);
  EXPECT_NEAR(error[0] / error[1], 4.0, 0.6) << "order 2: " << error[0] << ", " << error[1];
}

INSTANTIATE_TEST_SUITE_P(Protocols, CubicBars,
                         testing::Values(Method{"hughes_liu", 1, 400}, Method{"kim", 1, 400},
                                         Method{"prakash_hjelmstad", 1, 400}, Method{"gravouil_combescure", 1, 400},
                                         Method{"fixed_point", 1, 400}, Method{"all_explicit", 1, 10000}),
                         [](const auto& info) {
                           return fmt::format("{}_{}", info.param.protocol, info.param.substeps);
                         });

/// Protocols that take the answer of the start for the whole run.
TEST(CubicBars, AreRefusedByNameWhereTheAnswerOfTheStartServesForAllWindows) {
  const TemporaryFolder folder;
  for (const char* more : {"substeps = 2\n", "substeps = 4\n"}) {
    const std::string scene = scene_with("prakash_hjelmstad", 400, more);
    const RunResult run = run_file(folder.write(scene), folder);
    EXPECT_EQ(run.outcome.code, 2) << run.outcome.error;
    EXPECT_THAT(run.outcome.error, testing::HasSubstr("participant 'explicit', interface node 0, component 0: it does "
                                                      "not answer its link input linearly"));
  }
}

/// At the start it is linear to the last digit that is compared; later it is not, and the shared node would be moved by
/// a force that it does not have.
TEST(CubicBars, ThatAreLinearAtTheStartAloneEndTheRunUnderBelytschkoMullen) {
  const TemporaryFolder folder;
  const RunResult run = run_file(folder.write(scene_with("belytschko_mullen", 4000)), folder);
  EXPECT_EQ(run.outcome.code, 2) << run.outcome.error;
  EXPECT_THAT(run.outcome.error, testing::AllOf(testing::HasSubstr("participant 'explicit' is not linear any more: in "
                                                                   "window "),
                                                testing::HasSubstr("use hughes_liu, kim")));
  EXPECT_THAT(run.outcome.error, testing::Not(testing::HasSubstr("in window 1 "))) << "it begins";
}

TEST(CubicBars, AreNotWhatLinearBarsAre) { EXPECT_LT(quarter_period_s(), 0.65 * 0.5 * M_PI * std::sqrt(mass_kg)); }

}  // namespace
}  // namespace ricochet::test
