// Elements whose force is not linear in their displacement, behind the seam InternalForce: a mass on a spring of the
// force k u + k3 u^3, which is the explicit element of a bar, while the implicit one next to it is a thousandth as long
// and so all but rigid; and a mass between an explicit and an implicit element, of which either or both are not linear.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/cubic_bars.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

constexpr double speed_m_s = 0.01, short_element_m = 0.001;
constexpr double mass_kg = 0.5 + short_element_m;  ///< half of the long element and the short one

/// A quarter of the period of a mass M on springs of the force k (u + B u^3), k = 1 N/m for each. From M v^2/k + u^2 +
/// B u^4/2 = M V^2/k, with u = A sin(theta):
///   T/4 = integral_0^(pi/2) sqrt(M / k / (1 + B A^2 (1 + sin^2 theta)/2)) d theta
/// The integrand is periodic, so that the trapezoidal rule leaves nothing but round-off.
double quarter_period_s(double swinging_kg, int springs, int cubic) {
  const double b = stiffening * cubic / springs, ratio = swinging_kg / springs;
  const double square = (std::sqrt(1.0 + 2.0 * b * ratio * speed_m_s * speed_m_s) - 1.0) / b;
  constexpr int points = 64;
  double sum = 0.0;
  for (int i = 0; i <= points; ++i) {
    const double sine = std::sin(0.5 * M_PI * i / points), end = i == 0 || i == points ? 0.5 : 1.0;
    sum += end * std::sqrt(ratio / (1.0 + 0.5 * b * square * (1.0 + sine * sine)));
  }
  return sum * 0.5 * M_PI / points;
}

double quarter_period_s() { return quarter_period_s(mass_kg, 1, 1); }

std::string cubic_program(const std::string& bodies) {
  return fmt::format("executable = \"{}/cubic_participant\"\ndiffering_bodies = {}\n", build_folder(), bodies);
}

std::string scene_with(const std::string& protocol, int windows, const std::string& more = "") {
  const std::string cubic = cubic_program("[\"rod\"]");
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

/// Which of the two elements of a bar that is held at both ends are cubic, the explicit one and the implicit one.
enum class Cubic { explicit_side, implicit_side, both };

struct Between {
  const char* protocol;
  int substeps;
  Cubic cubic;
};

int cubic_springs(const Between& between) { return between.cubic == Cubic::both ? 2 : 1; }

/// A second body far away, which is never met, has its end named a contact: elements near a contact are implicit.
std::string scene_between(const Between& between, double step_s, double end_s) {
  const std::string protocol = between.protocol;
  std::string coupling = fmt::format("protocol = \"{}\"\n", protocol);
  if (protocol.find("all_") == std::string::npos) coupling += "after_separation = \"implicit\"\n";
  if (between.substeps > 1) coupling += fmt::format("substeps = {}\n", between.substeps);
  std::string participants;
  if (protocol != "all_implicit") {
    participants += "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"rod\"]\n";
    if (between.cubic != Cubic::implicit_side) participants += cubic_program("[\"rod\"]");
  }
  participants += "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  if (between.cubic != Cubic::explicit_side) participants += cubic_program("[\"rod\", \"stop\"]");
  return fmt::format(R"(model = "bar"
[[body]]
name = "rod"
material = {{ youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }}
mesh = {{ length_m = 2.0, elements = 2 }}
support = [{{ surface = "start", fixed = ["x"] }}, {{ surface = "end", fixed = ["x"] }}]
initial_velocity_m_s = [{}]
[[body]]
name = "stop"
material = {{ youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }}
mesh = {{ length_m = 1.0, elements = 1, start_m = 3.0 }}
[contact]
surfaces = ["rod.end", "stop.start"]
[partition]
implicit_length_m = {{ rod = 1.5, stop = 2.0 }}
[time]
step_s = {:.17g}
end_s = {:.17g}
[coupling]
{}{})",
                     speed_m_s, step_s, end_s, coupling, participants);
}

class MassBetweenCubicBars : public testing::TestWithParam<Between> {};

TEST_P(MassBetweenCubicBars, SwingsAsTheQuadratureOfItsEnergySays) {
  const double quarter_s = quarter_period_s(1.0, 2, cubic_springs(GetParam()));
  const TemporaryFolder folder;
  double error[2];
  for (const int k : {0, 1}) {
    const RunResult run = run_text(scene_between(GetParam(), quarter_s / (50 << k), 8.0 * quarter_s), folder,
                                   fmt::format("windows{}", k));
    error[k] = third_rest_s(run) / (5.0 * quarter_s) - 1.0;
    for (const double e : run.column("energy_error")) EXPECT_LT(std::abs(e), 5e-3);
  }
  EXPECT_LT(std::abs(error[0]), 2e-4);
  EXPECT_NEAR(error[0] / error[1], 4.0, 0.2) << "order 2: " << error[0] << ", " << error[1];
}

std::string name_of(const testing::TestParamInfo<Between>& info) {
  const char* const sides[] = {"explicit", "implicit", "both"};
  return fmt::format("{}_{}_{}", info.param.protocol, info.param.substeps, sides[static_cast<int>(info.param.cubic)]);
}

INSTANTIATE_TEST_SUITE_P(
    Protocols, MassBetweenCubicBars,
    testing::Values(Between{"hughes_liu", 1, Cubic::implicit_side}, Between{"hughes_liu", 1, Cubic::both},
                    Between{"kim", 1, Cubic::implicit_side}, Between{"kim", 1, Cubic::both},
                    Between{"kim_predicted", 1, Cubic::implicit_side}, Between{"fixed_point", 1, Cubic::implicit_side},
                    Between{"fixed_point", 1, Cubic::both}, Between{"belytschko_mullen", 1, Cubic::implicit_side},
                    Between{"prakash_hjelmstad", 1, Cubic::implicit_side}, Between{"prakash_hjelmstad", 1, Cubic::both},
                    Between{"prakash_hjelmstad", 2, Cubic::implicit_side},
                    Between{"prakash_hjelmstad", 4, Cubic::implicit_side},
                    Between{"gravouil_combescure", 1, Cubic::explicit_side}, Between{"all_implicit", 1, Cubic::both}),
    name_of);

class RefusedMassBetweenCubicBars : public testing::TestWithParam<std::pair<Between, const char*>> {};

TEST_P(RefusedMassBetweenCubicBars, IsRefusedByTheNameOfWhoIsNotLinear) {
  const auto& [between, refused] = GetParam();
  const TemporaryFolder folder;
  const RunResult run = run_file(folder.write(scene_between(between, 0.01, 1.0)), folder);
  EXPECT_EQ(run.outcome.code, 2) << run.outcome.error;
  EXPECT_THAT(run.outcome.error, testing::HasSubstr(refused));
  EXPECT_THAT(run.outcome.error,
              testing::HasSubstr("allowed: under this protocol, which takes the answer of the start"));
}

INSTANTIATE_TEST_SUITE_P(
    Protocols, RefusedMassBetweenCubicBars,
    testing::Values(std::pair(Between{"belytschko_mullen", 1, Cubic::explicit_side},
                              "participant 'explicit' is not linear any more"),
                    std::pair(Between{"belytschko_mullen", 1, Cubic::both},
                              "participant 'explicit' is not linear any more"),
                    std::pair(Between{"gravouil_combescure", 1, Cubic::implicit_side},
                              "participant 'implicit', interface node 0, component 0: it does not answer"),
                    std::pair(Between{"gravouil_combescure", 1, Cubic::both},
                              "participant 'implicit', interface node 0, component 0: it does not answer"),
                    std::pair(Between{"prakash_hjelmstad", 2, Cubic::explicit_side},
                              "participant 'explicit', interface node 0, component 0: it does not answer"),
                    std::pair(Between{"prakash_hjelmstad", 2, Cubic::both},
                              "participant 'explicit', interface node 0, component 0: it does not answer")),
    [](const auto& info) { return fmt::format("{}_{}", info.param.first.protocol, info.index); });

/// Among it: a trial again has the same bits, though Newton's iteration changes the operator, and so has a process that
/// goes on from what another one saved.
TEST(MassBetweenCubicBars, IsASoundParticipantOfEitherSide) {
  const TemporaryFolder folder;
  const std::string scene = folder.write(scene_between({"hughes_liu", 1, Cubic::both}, 0.02, 1.0));
  const Outcome checked = run_command({ricochet_binary(), "check-participant", "--scene", scene, "--name", "implicit"},
                                      folder.path().string());
  EXPECT_EQ(checked.code, 0) << checked.out;
  for (const char* clause : {"a repeated trial of a window gives the same bits",
                             "another process goes on from its saved state to the same bits",
                             "a stiffness on its interface acts like its force"})
    EXPECT_THAT(checked.out, testing::HasSubstr(std::string("passed   ") + clause));
}

TEST(MassBetweenCubicBars, GoesOnFromACheckpointToTheSameBytes) {
  const TemporaryFolder folder;
  const std::string text = scene_between({"hughes_liu", 1, Cubic::both}, 0.02, 2.0);
  const RunResult whole = run_text(with_key(text, "checkpoint", "every_windows", "50"), folder);
  const Outcome outcome = expect_the_same_from_the_earlier_checkpoint(whole, folder);
  EXPECT_THAT(outcome.error, testing::HasSubstr("going on from window 50"));
}

/// A bar of one element, pressed against a stop by its other end at a given rate: what stops it is N(strain).
TEST(CubicBars, PressOnAStopByTheForceOfTheirStrain) {
  const TemporaryFolder folder;
  const std::string scene = fmt::format(R"(model = "bar"
[[body]]
name = "rod"
material = {{ youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }}
mesh = {{ length_m = 1.0, elements = 1 }}
prescribed = [{{ surface = "start", component = "x", displacement_m = 0.01, amplitude = {{ time_s = [0.0, 1.0], factor = [0.0, 1.0] }} }}]
[contact]
surfaces = ["rod.end", "rigid_plane"]
[time]
step_s = 0.01
end_s = 1.0
[coupling]
protocol = "all_implicit"
[[participant]]
name = "implicit"
role = "implicit"
{})",
                                        cubic_program("[\"rod\"]"));
  const RunResult run = run_text(scene, folder);
  const auto &time = run.column("time_s"), &pressure = run.column("contact_pressure_mean_pa");
  const auto force = [](double t) {
    const double strain = 0.01 * t;
    return strain + stiffening * strain * strain * strain;
  };
  for (std::size_t n = 1; n < time.size(); ++n) {
    const double mean = 0.5 * (force(time[n - 1]) + force(time[n]));
    EXPECT_NEAR(pressure[n], mean, 1e-9 * force(1.0)) << "window " << n;
  }
}

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
                                                testing::HasSubstr("any body under hughes_liu, kim")));
  EXPECT_THAT(run.outcome.error, testing::Not(testing::HasSubstr("in window 1 "))) << "it begins";
}

TEST(CubicBars, AreNotWhatLinearBarsAre) { EXPECT_LT(quarter_period_s(), 0.65 * 0.5 * M_PI * std::sqrt(mass_kg)); }

}  // namespace
}  // namespace ricochet::test
