// Bodies that move as one, against bodies that deform.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <string>

#include "tests/support/both_momenta.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

std::string under(const std::string& protocol) {
  return fmt::format("[coupling]\nprotocol = \"{}\"\n{}", protocol,
                     protocol == "prakash_hjelmstad" ? "substeps = 2\n" : "");
}

constexpr const char* heavy = "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }";
constexpr const char* light = "{ youngs_modulus_pa = 50e9, poisson_ratio = 0.2, density_kg_m3 = 2500.0 }";

/// A mass of 16 g against a bar of impedance 4000 kg/s, at 1 m/s.
std::string mass_on_bar(const std::string& protocol, const std::string& more = "") {
  return "model = \"bar\"\n[[body]]\nname = \"mass\"\nrigid = true\narea_m2 = 1e-4\ninitial_velocity_m_s = [1.0]\n" +
         fmt::format("material = {}\nmesh = {{ start_m = -0.02, length_m = 0.02, elements = 1 }}\n", heavy) +
         fmt::format("[[body]]\nname = \"bar\"\nmaterial = {}\narea_m2 = 1e-4\n", heavy) +
         "mesh = { length_m = 0.2, elements = 800 }\n[contact]\nsurfaces = [\"mass.end\", \"bar.start\"]\n"
         "[partition]\nimplicit_length_m = { bar = 0.02 }\n[time]\nstep_s = 4e-8\nend_s = 3e-5\n" +
         more + under(protocol);
}

class RigidMass : public testing::TestWithParam<const char*> {};

/// F = Z v exp(-Z t/m) until the bar sends something back, Z = rho c A: m v (1 - exp(-Z t/m)) is given by then.
TEST_P(RigidMass, GivesABarItsMomentum) {
  const TemporaryFolder folder;
  const RunResult run = run_text(mass_on_bar(GetParam()), folder);
  const double z = 4000.0, m = 0.016;
  const auto &time = run.column("time_s"), &impulse = run.column("contact_impulse_n_s");
  for (std::size_t n = 0; n < time.size(); ++n)
    ASSERT_NEAR(impulse[n], m * (1.0 - std::exp(-z * time[n] / m)), 0.01 * m) << time[n];
  EXPECT_NEAR(impulse.back(), m, 2e-3 * m);
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Protocols, RigidMass,
                         testing::Values("hughes_liu", "belytschko_mullen", "prakash_hjelmstad", "gravouil_combescure",
                                         "fixed_point", "all_explicit", "all_implicit", "local_explicit"));

TEST(RigidMass, GoesOnFromACheckpoint) {
  const TemporaryFolder folder;
  const RunResult run = run_text(mass_on_bar("hughes_liu", "[checkpoint]\nevery_windows = 250\n"), folder);
  expect_the_same_from_the_earlier_checkpoint(run, folder);
}

/// A piston that is given its motion, from the start on: Z v until the end of the bar is heard of.
TEST(RigidPiston, PushesAsItIsTold) {
  const TemporaryFolder folder;
  const std::string given =
      "[[body.prescribed]]\nsurface = \"start\"\ncomponent = \"x\"\ndisplacement_m = 1e-4\n"
      "[body.prescribed.amplitude]\ntime_s = [0.0, 1e-4]\nfactor = [0.0, 1.0]\n";
  for (const char* protocol : {"hughes_liu", "all_explicit", "all_implicit"}) {
    const std::string scene = replaced(replaced(mass_on_bar(protocol), "initial_velocity_m_s = [1.0]\n", ""),
                                       "elements = 1 }\n", "elements = 1 }\n" + given);
    const RunResult run = run_text(scene, folder, protocol);
    EXPECT_NEAR(run.mean("contact_force_n", 5e-6, 3e-5) / 4000.0, 1.0, 1e-4) << protocol;
    EXPECT_NEAR(run.last("energy_external_j") / (4000.0 * 3e-5), 1.0, 1e-3) << protocol;
    EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9) << protocol;
  }
}

/// A cylinder with a nose of 10 mm against a thick plate: Hertz' law with the compliance of the plate alone.
TEST(RigidStriker, MeetsHertzWithThePlatesCompliance) {
  const TemporaryFolder folder;
  for (const char* protocol : {"hughes_liu", "all_explicit"}) {
    const RunResult run = run_text(
        fmt::format("model = \"axisymmetric\"\n[[body]]\nname = \"striker\"\nrigid = true\nmaterial = {}\n", heavy) +
            "initial_velocity_m_s = [0.0, -2.0]\nmesh = { length_m = 0.01, radius_m = 0.005, elements = [2, 2] }\n" +
            fmt::format("[[body]]\nname = \"plate\"\nmaterial = {}\n", light) +
            "mesh = { start_m = -0.03, length_m = 0.03, radius_m = 0.03, elements = [60, 60], grading = [20.0, 0.05] "
            "}\n"
            "[[body.absorbing]]\nsurface = \"start\"\nwave = \"dilatational\"\n"
            "[[body.absorbing]]\nsurface = \"outer\"\nwave = \"dilatational\"\n"
            "[contact]\nsurfaces = [\"striker.start\", \"plate.end\"]\nnose_radius_m = 0.01\n"
            "[partition]\nimplicit_length_m = { plate = 0.003 }\n[time]\nsafety_factor = 0.9\nend_s = 60e-6\n" +
            under(protocol),
        folder, protocol);
    const double m = 8000.0 * std::acos(-1.0) * 0.005 * 0.005 * 0.01, k = 4.0 / 3.0 * 50e9 / 0.96 * std::sqrt(0.01),
                 approach_m = std::pow(1.25 * m * 4.0 / k, 0.4);
    EXPECT_NEAR(run.largest("contact_force_n") / (k * std::pow(approach_m, 1.5)), 1.0, 0.015) << protocol;
    const auto &time = run.column("time_s"), &force = run.column("contact_force_n");
    double pressed_s = 0.0;
    for (std::size_t n = 1; n < time.size(); ++n) pressed_s += force[n] > 0.0 ? time[n] - time[n - 1] : 0.0;
    EXPECT_NEAR(pressed_s / (2.9432 * approach_m / 2.0), 1.0, 0.02) << protocol;
  }
}

using Vector = std::array<double, 3>;

/// x turned about a vector, by Rodrigues' formula.
Vector turned(const Vector& x, const Vector& about, double angle_rad) {
  const double length = std::hypot(about[0], about[1], about[2]);
  const Vector e = {about[0] / length, about[1] / length, about[2] / length};
  const Vector across = {e[1] * x[2] - e[2] * x[1], e[2] * x[0] - e[0] * x[2], e[0] * x[1] - e[1] * x[0]};
  const double along = e[0] * x[0] + e[1] * x[1] + e[2] * x[2], c = std::cos(angle_rad), s = std::sin(angle_rad);
  Vector y{};
  for (std::size_t i = 0; i < 3; ++i) y[i] = c * x[i] + s * across[i] + (1.0 - c) * along * e[i];
  return y;
}

/// One element of 20 x 20 x 10 mm turns like the free top that it is: about its angular momentum L at |L|/I_1, and
/// about its own axis at w_3 (I_1 - I_3)/I_1. Goldstein, Classical Mechanics, 5.6.
TEST(RigidBlock, TurnsLikeAFreeTop) {
  const TemporaryFolder folder;
  const double i1 = 0.02 * 0.02 + 0.01 * 0.01, i3 = 2.0 * 0.02 * 0.02, end_s = 1e-2;  // times m/12
  const Vector momentum = {i1 * 300.0, i1 * 100.0, i3 * 400.0}, arm = {0.01, 0.01, 0.005};
  const Vector place = turned(turned(arm, {0.0, 0.0, 1.0}, 400.0 * (i1 - i3) / i1 * end_s), momentum,
                              std::hypot(momentum[0], momentum[1], momentum[2]) / i1 * end_s);
  for (const char* protocol : {"all_explicit", "all_implicit"}) {
    const RunResult run = run_text(
        fmt::format("model = \"solid\"\n[[body]]\nname = \"block\"\nrigid = true\nlarge_rotation = true\n"
                    "initial_angular_velocity_rad_s = [300.0, 100.0, 400.0]\nmaterial = {}\n",
                    heavy) +
            "mesh = { length_m = 0.01, height_m = 0.02, width_m = 0.02, elements = [1, 1, 1] }\n"
            "[time]\nstep_s = 5e-7\nend_s = 0.01\n[output]\nhistory_every = 100\n"
            "probes_every = 100\n[[output.probe]]\nname = \"corner\"\nbody = \"block\"\nat_m = [0.02, 0.02, 0.01]\n" +
            under(protocol),
        folder, protocol);
    const History probes = read_history(run.folder + "/probes.csv");
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(probes.at(fmt::format("corner.displacement_{}_m", "xyz"[c])).back(), place[c] - arm[c], 3e-5)
          << protocol << " " << c;
    EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-7) << protocol;
  }
}

/// A block that falls askew on an edge of its own, with friction, both free to turn.
std::string spinning_block(const std::string& protocol, const std::string& more = "") {
  return fmt::format(
             "model = \"plane_strain\"\n[[body]]\nname = \"block\"\nrigid = true\nlarge_rotation = true\n"
             "material = {}\ninitial_velocity_m_s = [0.5, -2.0]\ninitial_angular_velocity_rad_s = 100.0\n"
             "mesh = {{ length_m = 0.01, height_m = 0.02, elements = [4, 2] }}\n",
             heavy) +
         fmt::format("[[body]]\nname = \"plate\"\nlarge_rotation = true\nmaterial = {}\n", light) +
         "mesh = { start_m = -0.02, length_m = 0.0199, height_m = 0.05, elements = [25, 10] }\n"
         "[contact]\nsurfaces = [\"block.start\", \"plate.end\"]\nfriction_coefficient = 0.3\n"
         "[partition]\nimplicit_length_m = { plate = 0.004 }\n[time]\nstep_s = 1.5e-7\nend_s = 150e-6\n" +
         more + under(protocol);
}

class RigidImpact : public testing::TestWithParam<const char*> {};

TEST_P(RigidImpact, KeepsBothMomenta) {
  const TemporaryFolder folder;
  const RunResult run = run_text(spinning_block(GetParam()), folder),
                  reference = run_text(spinning_block("all_implicit"), folder, "reference");
  expect_both_momenta(run, reference, 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Protocols, RigidImpact, testing::Values("hughes_liu", "fixed_point", "all_explicit"));

TEST(RigidImpact, GoesOnFromACheckpoint) {
  const TemporaryFolder folder;
  const RunResult run = run_text(spinning_block("hughes_liu", "[checkpoint]\nevery_windows = 300\n"), folder);
  expect_the_same_from_the_earlier_checkpoint(run, folder);
}

/// A block on a block of four elements an edge, a quarter of both or all of them.
std::string blocks(const std::string& protocol, bool quarter) {
  const auto body = [&](const char* name, const char* material, double start_m, double half_m, int half, int along) {
    const int across = quarter ? half : 2 * half;
    const double size_m = quarter ? half_m : 2.0 * half_m, moved_m = quarter ? 0.0 : -half_m;
    return fmt::format("[[body]]\nname = \"{}\"\nmaterial = {}\n", name, material) +
           fmt::format(
               "mesh = {{ start_m = {}, length_m = {}, height_m = {}, width_m = {}, elements = [{}, {}, {}], "
               "place = {{ moved_m = [{}, {}, 0.0] }} }}\n",
               start_m, start_m < 0.0 ? -start_m : 0.01, size_m, size_m, across, across, along, moved_m, moved_m) +
           (quarter ? "[[body.support]]\nsurface = \"inner\"\nfixed = [\"x\"]\n"
                      "[[body.support]]\nsurface = \"front\"\nfixed = [\"y\"]\n"
                    : "");
  };
  return "model = \"solid\"\n" +
         replaced(body("block", heavy, 0.0, 0.01, 2, 1), "[[body]]\n",
                  "[[body]]\nrigid = true\ninitial_velocity_m_s = [0.0, 0.0, -2.0]\n") +
         body("plate", light, -0.02, 0.02, 6, 8) +
         "[contact]\nsurfaces = [\"block.start\", \"plate.end\"]\nfriction_coefficient = 0.3\n"
         "[partition]\nimplicit_length_m = { plate = 0.003 }\n[time]\nstep_s = 2e-7\nend_s = 6e-5\n" +
         under(protocol);
}

/// Planes of symmetry that hold a quarter of it hold all of it.
TEST(RigidQuarter, HasAQuarterOfTheImpulse) {
  const TemporaryFolder folder;
  for (const char* protocol : {"hughes_liu", "all_explicit"}) {
    const RunResult whole = run_text(blocks(protocol, false), folder, "whole"),
                    quarter = run_text(blocks(protocol, true), folder, "quarter");
    EXPECT_NEAR(4.0 * quarter.last("contact_impulse_n_s") / whole.last("contact_impulse_n_s"), 1.0, 3e-3) << protocol;
    EXPECT_LT(quarter.summary["momentum_error_max"].get<double>(), 1e-11) << protocol;
    EXPECT_LT(whole.summary["angular_momentum_error_max"].get<double>(), 1e-3) << protocol;
    EXPECT_TRUE(quarter.summary["angular_momentum_error_max"].is_null()) << "guides take moments";
  }
}

/// It does not ask for a shorter step than the elements of the other body, however small its own.
TEST(RigidBlock, HasNoStepOfItsOwn) {
  const TemporaryFolder folder;
  const auto step_s = [&](const std::string& elements) {
    const std::string scene = folder.write(replaced(replaced(spinning_block("all_explicit"), "[4, 2]", elements),
                                                    "step_s = 1.5e-7", "safety_factor = 0.9"));
    const Outcome outcome = run_command({ricochet_binary(), "check", scene}, folder.path().string(), 60.0);
    EXPECT_EQ(outcome.code, 0) << outcome.error;
    EXPECT_THAT(outcome.out, testing::Not(HasSubstr("those of no material")));
    EXPECT_THAT(outcome.out, HasSubstr("  rigid\nplate "));
    return std::stod(outcome.out.substr(outcome.out.find("\nstep ") + 6));
  };
  EXPECT_DOUBLE_EQ(step_s("[1, 1]"), step_s("[80, 40]"));
}

TEST(WrongRigidBodies, AreRefusedByName) {
  const std::string scene = spinning_block("all_explicit"), mesh = "mesh = { length_m = 0.01,";
  EXPECT_THAT(check_refusal(replaced(scene, mesh,
                                     "support = [{ at_m = [0.0, 0.0], fixed = [\"x\"] }]\nmesh = { length_m = 0.01,")),
              HasSubstr("body.block.rigid: found true beside a support with at_m; allowed: supports of surfaces"));
  const auto beside = [&](const std::string& more) { return check_refusal(replaced(scene, mesh, more + mesh)); };
  EXPECT_THAT(beside("support = [{ surface = \"end\", fixed = [\"x\"] }]\n"),
              HasSubstr("body.block.rigid: found true beside large_rotation and a support or prescribed displacement"));
  EXPECT_THAT(beside("initial_displacement_m = { start = [0.0, 0.0], end = [0.0, 1e-6] }\n"),
              HasSubstr("body.block.rigid: found true beside initial_displacement_m that strains it"));
  EXPECT_THAT(check_refusal(replaced(scene, "elements = [4, 2] }", "elements = [4, 2], periodic_across = true }")),
              HasSubstr("body.block.rigid: found true beside mesh.periodic_across"));
  EXPECT_THAT(check_refusal(replaced(scene, "friction_coefficient = 0.3\n", "multiplier_update = \"massless\"\n")),
              HasSubstr("by mesh.refine, a tie or rigid = true"));
  EXPECT_THAT(check_refusal(replaced(spinning_block("fixed_point"), "[partition]\n",
                                     "[partition]\nreduced_modes = { block = 8 }\n")),
              HasSubstr("modes of a body with rigid"));
  EXPECT_THAT(check_refusal(replaced(scene, mesh, "absorbing = [{ surface = \"end\", wave = \"bar\" }]\n" + mesh)),
              HasSubstr("body.block.rigid: found true beside absorbing; allowed: surfaces without it"));
  EXPECT_THAT(check_refusal(replaced(scene, "density_kg_m3 = 8000.0 }",
                                     "density_kg_m3 = 8000.0, plasticity = { yield_stress_pa = 1e8 } }")),
              HasSubstr("body.block.rigid: found true beside plasticity"));
  EXPECT_THAT(check_refusal(
                  replaced(scene, "elements = [4, 2] }",
                           "elements = [4, 2], refine = [{ from_m = [0.0, 0.0], to_m = [0.01, 0.01], ratio = 2 }] }")),
              HasSubstr("body.block.rigid: found true beside mesh.piece or mesh.refine"));
  EXPECT_THAT(check_refusal(replaced(replaced(scene, "\"plate.end\"", "\"rigid_plane\""),
                                     "[partition]\nimplicit_length_m = { plate = 0.004 }\n", "")),
              HasSubstr("contact.surfaces: found rigid body \"block\" against a rigid obstacle; allowed: a body that "
                        "deforms on one side at least"));
  EXPECT_THAT(check_refusal(replaced(replaced(scene, "name = \"plate\"\n", "name = \"plate\"\nrigid = true\n"),
                                     "[partition]\nimplicit_length_m = { plate = 0.004 }\n", "")),
              HasSubstr("found two rigid bodies, \"block\" and \"plate\""));
  EXPECT_THAT(
      check_refusal(replaced(spinning_block("hughes_liu"), "{ plate = 0.004 }", "{ plate = 0.004, block = 0.002 }")),
      HasSubstr("partition.implicit_length_m"));
}

}  // namespace
}  // namespace ricochet::test
