// Surfaces and bodies that are told how to turn, by any angle, against formulas.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr const char* turned_steel = "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.25, density_kg_m3 = 8000.0 }";

/// From 0 to a number of times of it at `end_s`.
std::string given_turn(const std::string& turn_rad, const std::string& about_m, double factor, double end_s) {
  return fmt::format(
      "[[body.prescribed]]\nsurface = \"start\"\nturn_rad = {}\nabout_m = {}\n"
      "amplitude = {{ time_s = [0.0, {}], factor = [0.0, {}] }}\n",
      turn_rad, about_m, end_s, factor);
}

std::string turned_under(const std::string& protocol) {
  return fmt::format("[coupling]\nprotocol = \"{}\"\n", protocol);
}

/// A tool that turns by seven radians about an axis of its own, which moves along z meanwhile.
TEST(PrescribedTurn, MovesARigidBodyByAnyAngle) {
  const TemporaryFolder folder;
  const RunResult run = run_text(
      fmt::format("model = \"solid\"\n[[body]]\nname = \"tool\"\nrigid = true\nlarge_rotation = true\nmaterial = {}\n",
                  turned_steel) +
          "mesh = { length_m = 0.01, height_m = 0.02, width_m = 0.02, elements = [1, 1, 1] }\n" +
          given_turn("[2.0, 3.0, 6.0]", "[0.01, 0.02, 0.03]", 1.0, 0.01) +
          "[[body.prescribed]]\nsurface = \"start\"\ncomponent = \"z\"\ndisplacement_m = 0.05\n"
          "amplitude = { time_s = [0.0, 0.01], factor = [0.0, 1.0] }\n"
          "[time]\nstep_s = 5e-7\nend_s = 0.008\n[output]\nhistory_every = 100\nprobes_every = 100\n"
          "[[output.probe]]\nname = \"corner\"\nbody = \"tool\"\nat_m = [0.02, 0.02, 0.01]\n" +
          turned_under("all_explicit"),
      folder);
  const std::array<double, 3> axis = {2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0}, arm = {0.01, 0.0, -0.02};
  const double angle = 7.0 * 0.8, c = std::cos(angle), s = std::sin(angle);
  const double along = axis[0] * arm[0] + axis[1] * arm[1] + axis[2] * arm[2];
  const History probes = read_history(run.folder + "/probes.csv");
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double across = axis[j] * arm[k] - axis[k] * arm[j];
    const double moved = (c - 1.0) * arm[i] + s * across + (1.0 - c) * along * axis[i] + (i == 2 ? 0.04 : 0.0);
    EXPECT_NEAR(probes.at(fmt::format("corner.displacement_{}_m", "xyz"[i])).back(), moved, 1e-12) << i;
  }
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-9);
  EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-7);
  EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9);
  EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -1e-9);
}

/// The end of a round bar is twisted with a rate w: the wave of torsion takes the moment rho c J w, c = sqrt(G/rho),
/// J = pi r^4/2, whose impulse is the angular momentum and whose work the energy.
TEST(PrescribedTurn, SendsAWaveOfTorsionIntoABar) {
  const TemporaryFolder folder;
  const double pi = std::acos(-1.0), c = std::sqrt(80e9 / 8000.0), rate = 100.0,
               moment = 8000.0 * c * 0.5 * pi * std::pow(0.005, 4) * rate;
  for (const std::string protocol : {"all_explicit", "all_implicit"}) {
    const RunResult run =
        run_text(fmt::format("model = \"solid\"\n[[body]]\nname = \"bar\"\nmaterial = {}\n", turned_steel) +
                     "mesh = { length_m = 0.07, radius_m = 0.005, elements = [8, 50] }\n" +
                     given_turn("[0.0, 0.0, 1.0]", "[0.0, 0.0, 0.0]", 40.0 * rate, 40.0) +
                     fmt::format("[time]\nstep_s = {}\nend_s = 2e-5\n", protocol == "all_explicit" ? 5e-8 : 2e-7) +
                     turned_under(protocol),
                 folder, protocol);
    EXPECT_NEAR(run.last("angular_momentum_z_kg_m2_s") / (moment * 2e-5), 1.0, 0.01) << protocol;
    const auto &time = run.column("time_s"), &work = run.column("energy_external_j");
    const std::size_t last = time.size() - 1, first = last / 2;
    EXPECT_NEAR((work[last] - work[first]) / (moment * rate * (time[last] - time[first])), 1.0, 0.01) << protocol;
    EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9) << protocol;
    EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -1e-9) << protocol;
  }
}

/// A rod that turns as if it were rigid, and is held by one end so: the load rho w^2 r comes at once, and the rod
/// vibrates about its rest at rho w^2 L^3/(3 E) up to twice that.
TEST(PrescribedTurn, StretchesARodByItsOwnInertia) {
  const TemporaryFolder folder;
  const double rest_m = 8000.0 * 500.0 * 500.0 * 1e-3 / 3.0 / 200e9;
  for (const char* protocol : {"all_explicit", "all_implicit"}) {
    const RunResult run = run_text(
        "model = \"plane_strain\"\n[[body]]\nname = \"rod\"\nlarge_rotation = true\n"
        "initial_angular_velocity_rad_s = 500.0\ninitial_velocity_m_s = [-25.0, 0.0]\n"
        "material = { youngs_modulus_pa = 200e9, poisson_ratio = 0.0, density_kg_m3 = 8000.0 }\n"
        "mesh = { length_m = 0.1, height_m = 0.01, elements = [4, 40], place = { moved_m = [-0.005, 0.0] } }\n" +
            given_turn("1.0", "[0.0, 0.0]", 500.0, 1.0) +
            "[time]\nstep_s = 2e-7\nend_s = 0.004\n[output]\nprobes_every = 1\n"
            "[[output.probe]]\nname = \"tip\"\nbody = \"rod\"\nat_m = [0.0, 0.1]\n" +
            turned_under(protocol),
        folder, protocol);
    const History probes = read_history(run.folder + "/probes.csv");
    const auto &x = probes.at("tip.displacement_x_m"), &y = probes.at("tip.displacement_y_m");
    double sum_m = 0.0, most_m = 0.0;
    for (std::size_t n = 0; n < x.size(); ++n) {
      const double longer_m = std::hypot(x[n], 0.1 + y[n]) - 0.1;
      sum_m += longer_m;
      most_m = std::max(most_m, longer_m);
    }
    EXPECT_NEAR(sum_m / static_cast<double>(x.size()) / rest_m, 1.0, 1e-3) << protocol;
    EXPECT_NEAR(most_m / rest_m, 2.0, 2e-3) << protocol;
    EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-10) << protocol;
    EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-7) << protocol;
    EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-7) << protocol;
    EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -1e-7) << protocol;
  }
}

/// A rocker whose corner comes up under a block that falls on it.
std::string rocker(const std::string& protocol, const std::string& more) {
  return fmt::format(
             "model = \"plane_strain\"\n[[body]]\nname = \"rocker\"\nrigid = true\nlarge_rotation = true\n"
             "material = {}\nmesh = {{ start_m = -0.005, length_m = 0.005, height_m = 0.01, elements = [10, 5] }}\n",
             turned_steel) +
         given_turn("1.0", "[0.005, -0.0025]", 300.0, 1.0) +
         fmt::format(
             "[[body]]\nname = \"block\"\nlarge_rotation = true\nmaterial = {}\n"
             "initial_velocity_m_s = [0.0, -1.0]\nmesh = {{ start_m = 0.001, length_m = 0.004, height_m = 0.008, "
             "elements = [16, 8], place = {{ moved_m = [0.004, 0.0] }} }}\n",
             turned_steel) +
         "[contact]\nsurfaces = [\"block.start\", \"rocker.end\"]\n" + more +
         "[time]\nstep_s = 4e-8\nend_s = 6e-4\n[checkpoint]\nevery_windows = 5000\n" + turned_under(protocol);
}

class Rocker : public testing::TestWithParam<const char*> {};

/// Without friction the surfaces' normals, which turn, have a part sideways: the block gets it, too.
TEST_P(Rocker, ThrowsTheBlockAsItsSurfaceTells) {
  const TemporaryFolder folder;
  const RunResult run = run_text(rocker(GetParam(), ""), folder);
  const double sideways = run.last("normal_impulse_t_n_s");
  ASSERT_GT(sideways, 1e-5);
  const auto& momentum = run.column("momentum_t_kg_m_s");
  EXPECT_NEAR((momentum.front() - momentum.back()) / sideways, 1.0, 1e-6);
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-9);
  EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-3);
  EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9);
  EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -0.03)
      << "a node that the corner strikes gives its energy up";
}

TEST_P(Rocker, RubsByItsCoefficient) {
  const TemporaryFolder folder;
  const RunResult run = run_text(rocker(GetParam(), "friction_coefficient = 0.3\n"), folder);
  EXPECT_NEAR(run.last("friction_impulse_n_s") / (0.3 * run.last("contact_impulse_n_s")), 1.0, 0.15);
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-9);
  EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -0.03)
      << "a node that the corner strikes gives its energy up";
  expect_the_same_from_the_earlier_checkpoint(run, folder);
}

INSTANTIATE_TEST_SUITE_P(Protocols, Rocker, testing::Values("all_explicit", "all_implicit", "hughes_liu"));

TEST(WrongTurns, AreRefusedByName) {
  const std::string scene = rocker("all_explicit", "");
  const auto given = [&](const std::string& from, const std::string& to) {
    return check_refusal(replaced(scene, from, to));
  };
  EXPECT_THAT(given("turn_rad = 1.0", "component = \"x\"\nturn_rad = 1.0"),
              HasSubstr("body.rocker.prescribed[0].component: found \"x\"; allowed: only with no turn_rad beside it"));
  EXPECT_THAT(
      given("turn_rad = 1.0", "component = \"x\"\ndisplacement_m = 1e-3"),
      HasSubstr("body.rocker.prescribed[0].about_m: found an array of 2; allowed: only with turn_rad beside it"));
  EXPECT_THAT(given("turn_rad = 1.0\nabout_m = [0.005, -0.0025]", "component = \"x\"\ndisplacement_m = 1e-3"),
              HasSubstr("body.rocker.rigid: found true beside large_rotation and a support or prescribed "
                        "displacement; allowed: one of the two, or a prescribed turn"));
  const std::string turned = given_turn("1.0", "[0.005, -0.0025]", 300.0, 1.0);
  EXPECT_THAT(given(turned, turned + turned), HasSubstr("held by body.rocker.prescribed[0] already; allowed: one"));
  EXPECT_THAT(given(turned, turned + "[[body.support]]\nsurface = \"end\"\nfixed = [\"x\"]\n"),
              HasSubstr("held by body.rocker.support[0] already"));
}

TEST(WrongTurns, NothingFreeIsNoImplicitSide) {
  const std::string scene =
      fmt::format("model = \"plane_strain\"\n[[body]]\nname = \"tool\"\nrigid = true\nmaterial = {}\n", turned_steel) +
      "mesh = { length_m = 0.01, height_m = 0.01, elements = [1, 1] }\n" + given_turn("0.01", "[0.0, 0.0]", 1.0, 1e-3) +
      "[time]\nstep_s = 1e-6\nend_s = 1e-4\n";
  EXPECT_THAT(check_refusal(scene + turned_under("all_implicit")),
              HasSubstr("partition: found nothing that moves freely on the implicit side"));
}

}  // namespace
}  // namespace ricochet::test
