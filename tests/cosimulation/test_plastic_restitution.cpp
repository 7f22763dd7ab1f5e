// A round nose that yields rebounds from a plane by a share of its speed that falls with the speed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

constexpr double young_pa = 48e9, nu = 0.2, density = 2800.0, yield_pa = 5e6;
constexpr double radius_m = 0.006, length_m = 0.015, nose_m = 0.01;

std::string striker(double speed_m_s) {
  return fmt::format(R"(model = "axisymmetric"
[[body]]
name = "striker"
material = {{ youngs_modulus_pa = {}, poisson_ratio = {}, density_kg_m3 = {}, plasticity = {{ yield_stress_pa = {} }} }}
mesh = {{ length_m = {}, radius_m = {}, elements = [50, 50], grading = [15.0, 40.0] }}
initial_velocity_m_s = [0.0, {}]
[contact]
surfaces = ["striker.start", "rigid_plane"]
nose_radius_m = {}
[time]
safety_factor = 0.8
end_s = 400e-6
until_separated_plus_s = 20e-6
[coupling]
protocol = "all_explicit"
outside_model = "go_on"
[output]
history_every = 40
)",
                     young_pa, nu, density, yield_pa, length_m, radius_m, -speed_m_s, nose_m);
}

/// Once plastic all over, e = 3.8 (Y/E*)^1/2 (m v^2/2/(Y R^3))^-1/8, as v^-1/4 (Johnson: Contact Mechanics, 1985,
/// section 11.5c), with E* = E/(1 - nu^2) on a rigid plane and a mean pressure of 3 Y. Contact takes 100 us and a wave
/// 7 us to the far end and back, so that the striker counts as a mass alone. At the lowest speed 5 elements touch.
double johnson(double speed_m_s) {
  const double mass_kg = density * std::numbers::pi * radius_m * radius_m * length_m;
  const double strain = yield_pa * (1.0 - nu * nu) / young_pa;
  const double energy = 0.5 * mass_kg * speed_m_s * speed_m_s / (yield_pa * std::pow(nose_m, 3.0));
  return 3.8 * std::sqrt(strain) * std::pow(energy, -0.125);
}

TEST(PlasticRestitution, FallsWithTheFourthRootOfTheSpeedOverTwoDecades) {
  const TemporaryFolder folder;
  std::vector<double> restitution;
  for (const double speed_m_s : {0.01, 0.1, 1.0}) {
    const RunResult run = run_text(striker(speed_m_s), folder, fmt::format("v{}", speed_m_s));
    EXPECT_TRUE(run.summary.at("separation_time_s").is_number());
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
    const auto& plastic = run.column("plastic_work_j");
    const double kinetic_j = run.column("energy_kinetic_j").front();
    restitution.push_back(std::abs(run.last("velocity_mean_striker_m_s")) / speed_m_s);
    EXPECT_NEAR(restitution.back() / johnson(speed_m_s), 1.0, 0.1) << speed_m_s;
    // The energy that neither yielding nor the rebound takes is left in vibrations: little.
    EXPECT_NEAR(plastic.back() / kinetic_j, 1.0 - restitution.back() * restitution.back(), 0.06) << speed_m_s;
  }
  EXPECT_NEAR(std::log10(restitution[2] / restitution[1]), -0.25, 0.01);
  EXPECT_NEAR(0.5 * std::log10(restitution[2] / restitution[0]), -0.25, 0.03);
}

}  // namespace
}  // namespace ricochet::test
