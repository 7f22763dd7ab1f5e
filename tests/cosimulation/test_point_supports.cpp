// body.support with at_m: one node is held. A rod that hangs on one swings like a pendulum.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <string>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr double rod_length_m = 0.2, width_m = 0.02, gravity_m_s2 = 1000.0, probe_m = 0.19;
const double first_rad = std::numbers::pi / 3.0;  // from the vertical

/// A rod that is let go at 60 degrees, held at the middle of its upper end.
std::string pendulum(const std::string& support, const std::string& run) {
  return fmt::format(R"(model = "plane_strain"
[[body]]
name = "rod"
material = {{ youngs_modulus_pa = 1e10, poisson_ratio = 0.3, density_kg_m3 = 1000.0 }}
mesh = {{ start_m = -{}, length_m = {}, height_m = {}, elements = [2, 20], place = {{ turned_deg = 60.0, about_m = [0.01, 0.0] }} }}
large_rotation = true
gravity_m_s2 = [0.0, -{}]
support = [{}]
{}
[[output.probe]]
name = "tip"
body = "rod"
at_m = [{:.12g}, {:.12g}]
)",
                     rod_length_m, rod_length_m, width_m, gravity_m_s2, support, run,
                     0.01 + probe_m * std::sin(first_rad), -probe_m * std::cos(first_rad));
}

const std::string held = "{ at_m = [0.01, 0.0], fixed = [\"x\", \"y\"] }";

class Pendulum : public testing::TestWithParam<const char*> {};

// A quarter of the period is K(sin(first/2)) sqrt(I/(m g d)), K the complete elliptic integral, I about the support.
TEST_P(Pendulum, SwingsInTheTimeOfAnEllipticIntegral) {
  const TemporaryFolder folder;
  const double inertia_m2 =
      (rod_length_m * rod_length_m + width_m * width_m) / 12.0 + 0.25 * rod_length_m * rod_length_m;
  const double rate_rad_s = std::sqrt(gravity_m_s2 * 0.5 * rod_length_m / inertia_m2);
  const double quarter_s = std::comp_ellint_1(std::sin(0.5 * first_rad)) / rate_rad_s;
  const bool implicit = std::string(GetParam()) == "all_implicit";
  const RunResult run = run_text(
      pendulum(held, fmt::format(
                         "[time]\nstep_s = {}\nend_s = {}\n[coupling]\nprotocol = \"{}\"\n[output]\nprobes_every = {}",
                         implicit ? 2e-5 : 2e-6, 4.0 * quarter_s, GetParam(), implicit ? 1 : 10)),
      folder);
  const History probes = read_history(run.folder + "/probes.csv");
  const auto &time_s = probes.at("time_s"), &x_m = probes.at("tip.displacement_x_m");
  const auto &vx = probes.at("tip.velocity_x_m_s"), &vy = probes.at("tip.velocity_y_m_s");
  std::vector<double> lowest_s;  // where the probe is below the support
  double fastest_m_s = 0.0;
  for (std::size_t i = 1; i < x_m.size(); ++i) {
    fastest_m_s = std::max(fastest_m_s, std::hypot(vx[i], vy[i]));
    const auto beside = [&](std::size_t row) { return probe_m * std::sin(first_rad) + x_m[row]; };
    if (beside(i - 1) * beside(i) < 0.0)
      lowest_s.push_back(time_s[i - 1] + (time_s[i] - time_s[i - 1]) * beside(i - 1) / (beside(i - 1) - beside(i)));
  }
  ASSERT_EQ(lowest_s.size(), 2U);
  EXPECT_NEAR(lowest_s[0] / quarter_s, 1.0, 2e-3);
  EXPECT_NEAR(lowest_s[1] / (3.0 * quarter_s), 1.0, 2e-3);
  EXPECT_NEAR(fastest_m_s / (probe_m * rate_rad_s * std::sqrt(2.0 * (1.0 - std::cos(first_rad)))), 1.0, 5e-3);
  EXPECT_NEAR(x_m.back(), 0.0, 2e-3 * probe_m) << "it is back";
  EXPECT_LT(std::abs(run.last("energy_error")), 1e-3);
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-8);
  EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Protocols, Pendulum, testing::Values("all_explicit", "all_implicit"),
                         [](const auto& test) { return std::string(test.param); });

TEST(PointSupport, IsRefusedWhereNoNodeIs) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& support) {
    const std::string scene = folder.write(pendulum(
        support,
        "[time]\nstep_s = 2e-6\nend_s = 1e-3\n[coupling]\nprotocol = \"all_explicit\"\n[output]\nprobes_every = 1"));
    const Outcome outcome = run_command({ricochet_binary(), "check", scene}, folder.path().string());
    EXPECT_EQ(outcome.code, 2);
    return outcome.error;
  };
  EXPECT_THAT(refused("{ at_m = [0.011, 0.0], fixed = [\"x\"] }"),
              HasSubstr("body.rod.support[0].at_m: found no node at (0.011, 0) m; allowed: the place of a node, the "
                        "nearest is node"));
  EXPECT_THAT(refused("{ at_m = [0.01], fixed = [\"x\"] }"), HasSubstr("2 numbers"));
  EXPECT_THAT(refused("{ at_m = [0.01, 0.0], surface = \"end\", fixed = [\"x\"] }"),
              HasSubstr("surface: found \"end\"; allowed: only with no at_m beside it"));
}

}  // namespace
}  // namespace ricochet::test
