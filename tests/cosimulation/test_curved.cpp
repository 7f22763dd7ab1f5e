// configs/two_balls.toml: contact of curved surfaces whose meshes do not match, against Hertz' theory.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

/// Two equal balls of radius R that approach at +-v (Hertz 1882): with R' = R/2, m' = m/2, E' = E/(2 (1 - nu^2)),
///   closest approach d = (15 m' (2v)^2 / (16 sqrt(R') E'))^(2/5),  force 4/3 E' sqrt(R') d^(3/2),  time 2.9432 d/(2v).
struct Hertz {
  double force_n, duration_s;

  explicit Hertz(double v_m_s) {
    constexpr double e = 48e9, nu = 0.2, density = 2800.0, radius = 0.01;
    const double mass = 0.5 * density * 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3), closing = 2.0 * v_m_s,
                 modulus = e / (2.0 * (1.0 - nu * nu)), root = std::sqrt(0.5 * radius),
                 approach = std::pow(15.0 * mass * closing * closing / (16.0 * root * modulus), 0.4);
    force_n = 4.0 / 3.0 * modulus * root * std::pow(approach, 1.5);
    duration_s = 2.9432 * approach / closing;
  }
};

/// A scene of configs/ whose meshes are found from anywhere.
std::string scene_with(const std::string& name, const std::string& protocol) {
  std::string text = with_protocol_of_two_steps(config_text(name), protocol);
  const std::string mesh = "gmsh = \"";
  for (std::size_t at = text.find(mesh); at != std::string::npos; at = text.find(mesh, at + mesh.size()))
    text.insert(at + mesh.size(), source_folder() + "/configs/");
  return protocol == "all_explicit" ? replaced(text, "step_s = 5e-8", "safety_factor = 0.9") : text;
}

std::string balls(const std::string& protocol, const std::string& speed, const std::string& end_s) {
  std::string text = scene_with("two_balls", protocol);
  text = replaced(text, "[0.0, 10.0]", fmt::format("[0.0, {}]", speed));
  text = replaced(text, "[0.0, -10.0]", fmt::format("[0.0, -{}]", speed));
  return with_key(text, "time", "end_s", end_s);
}

double duration_s(const RunResult& run) {
  const auto &force = run.column("contact_force_n"), &time = run.column("time_s");
  double first = -1.0, last = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    if (force[i] == 0.0) continue;
    if (first < 0.0) first = time[i];
    last = time[i];
  }
  return last - first;
}

class TwoBalls : public testing::TestWithParam<const char*> {};

/// Hertz' half-spaces are stiffer than balls of finite size are soft: his force is exceeded the more the larger the
/// contact is against the ball, as its radius is to theirs, v^(2/5). At 10 m/s one ball on a rigid plane, which is the
/// same by symmetry, has +5.44, +5.34 and +5.35 % with these elements, half and a quarter as large; two balls have
/// +5.31, +5.32 and +5.34 %, in either order of the names +5.37, +5.33 and +5.34 %.
TEST_P(TwoBalls, CollideAsHertzHasItButForTheirSize) {
  EXPECT_NEAR(Hertz(10.0).force_n, 10697.0, 1.0);
  EXPECT_NEAR(Hertz(10.0).duration_s, 40.34e-6, 0.01e-6);
  struct Case {
    double speed_m_s;
    const char *speed, *end_s;
    double force, duration;
  };
  for (const Case& c : {Case{10.0, "10.0", "60e-6", 1.053, 0.966}, Case{1.0, "1.0", "90e-6", 1.017, 0.988}}) {
    const TemporaryFolder folder;
    const RunResult run = run_text(balls(GetParam(), c.speed, c.end_s), folder);
    const Hertz exact(c.speed_m_s);
    const double peak = run.summary.at("peak_contact_force_n");
    EXPECT_NEAR(peak / exact.force_n, c.force, 0.004) << c.speed;
    EXPECT_NEAR(duration_s(run) / exact.duration_s, c.duration, 0.004) << c.speed;
    // The impulse is what changes the momentum, 2 m v of either ball but for what goes into vibrations.
    const double mass = 2800.0 * 4.0 / 3.0 * std::numbers::pi * 1e-6;
    EXPECT_NEAR(run.last("contact_impulse_n_s") / (2.0 * mass * c.speed_m_s), 1.0, 5e-3);
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
    EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 1e-4);
    // With the force that there is: a = (3 F R' / (4 E'))^(1/3), p0 = 3/2 F/(pi a^2); a to an element, of 0.1 mm.
    const double modulus = 48e9 / (2.0 * 0.96), radius = std::cbrt(0.75 * peak * 0.005 / modulus),
                 pressure = 1.5 * peak / (std::numbers::pi * radius * radius);
    EXPECT_NEAR(run.summary.at("largest_contact_radius_m").get<double>(), radius, 1e-4) << c.speed;
    EXPECT_NEAR(run.summary.at("peak_contact_pressure_pa").get<double>(), pressure, 0.06 * pressure) << c.speed;
    EXPECT_EQ(run.summary.at("largest_contact_radius_m").get<double>(), run.largest("contact_radius_m"));
    EXPECT_TRUE(run.summary.at("angular_momentum_error_max").is_null()) << "there is none about an axis";
    EXPECT_EQ(run.history.count("angular_momentum_z_kg_m2_s"), 0U);
    EXPECT_THAT(run.outcome.out, testing::HasSubstr("mm radius"));
  }
}

/// Quarters of the balls, of coarse tetrahedra: 7.0 % above Hertz where the axisymmetric mesh is 5.3 % above. Supports
/// on planes of symmetry take the forces across them.
TEST_P(TwoBalls, AsSolidsHaveAQuarterOfThatForce) {
  const TemporaryFolder folder;
  const RunResult run = run_text(scene_with("two_balls_solid", GetParam()), folder);
  const double peak = run.summary.at("peak_contact_force_n");
  EXPECT_NEAR(4.0 * peak / Hertz(10.0).force_n, 1.0695, 0.004);
  EXPECT_NEAR(duration_s(run) / Hertz(10.0).duration_s, 0.915, 0.004);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
  EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Protocols, TwoBalls,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// By symmetry one ball on a rigid plane, at half the closing speed, has the same force.
TEST(OneBall, OnARigidPlaneHasTheForceOfTwo) {
  const TemporaryFolder folder, plane_folder;
  const RunResult two = run_text(balls("all_implicit", "10.0", "25e-6"), folder);
  std::string text = balls("all_implicit", "10.0", "25e-6");
  const auto upper = text.find("[[body]]\nname = \"upper\"");
  text = text.substr(0, upper) + text.substr(text.find("[contact]"));
  const RunResult one = run_text(replaced(text, "\"upper.upper_cap\"", "\"rigid_plane\""), plane_folder);
  EXPECT_NEAR(one.summary.at("peak_contact_force_n").get<double>(),
              two.summary.at("peak_contact_force_n").get<double>(), 0.01 * Hertz(10.0).force_n);
  // Forces of all directions about the axis have one resultant, which changes the momentum.
  const auto& momentum = one.column("momentum_n_kg_m_s");
  EXPECT_NEAR(one.last("contact_impulse_n_s"), momentum.front() - momentum.back(), 1e-11 * momentum.front());
  EXPECT_GT(one.last("contact_impulse_n_s"), 0.5 * momentum.front());
}

/// A ball of radius R on a rigid sphere of the same or four times the radius: with R' = R R_s/(R + R_s), E' = E/(1 -
/// nu^2) and the ball's mass Hertz' force is exceeded by 0.7 % and 1.3 % at 1 m/s, as of two balls by their size.
TEST(OneBall, OnARigidSphereHasTheForceOfHertz) {
  for (const auto& [sphere_m, expected] : {std::pair{0.01, 1.007}, {0.04, 1.013}}) {
    const TemporaryFolder folder;
    std::string text = balls("all_implicit", "1.0", "90e-6");
    const auto upper = text.find("[[body]]\nname = \"upper\"");
    text = text.substr(0, upper) + text.substr(text.find("[contact]"));
    text = replaced(text, "\"upper.upper_cap\"]", fmt::format("\"rigid_sphere\"]\nrigid_radius_m = {}", sphere_m));
    const RunResult run = run_text(text, folder);
    const double mass = 2800.0 * 4.0 / 3.0 * std::numbers::pi * 1e-6, modulus = 48e9 / (1.0 - 0.2 * 0.2),
                 root = std::sqrt(0.01 * sphere_m / (0.01 + sphere_m)),
                 approach = std::pow(15.0 * mass / (16.0 * root * modulus), 0.4),
                 force = 4.0 / 3.0 * modulus * root * std::pow(approach, 1.5);
    EXPECT_NEAR(run.summary.at("peak_contact_force_n").get<double>() / force, expected, 0.004) << sphere_m;
    EXPECT_NEAR(duration_s(run) / (2.9432 * approach), 0.987, 0.004) << sphere_m;
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
  }
}

}  // namespace
}  // namespace ricochet::test
