#include <fmt/format.h>

#include "tests/support/block_mesh.hpp"
#include "tests/support/run.hpp"

// Solids through scene files and real processes. Without a Poisson's ratio a solid that moves along its axis is a bar:
// every hexahedron of a cross section does the same, and what three processes compute is what they compute of bars, to
// round-off, whatever the protocol.

namespace ricochet::test {
namespace {

/// configs/two_bars.toml with `model`, its bodies as bars or as blocks of 2 x 3 elements of the same cross section.
std::string two_bodies(bool solid, const std::string& coupling, const std::string& more = "") {
  std::string text = config_text("two_bars");
  for (const std::string sign : {"", "-"}) {
    if (!solid) break;
    text = replaced(text, "youngs_modulus_pa = 206.8e9, density",
                    "youngs_modulus_pa = 206.80e9, poisson_ratio = 0.0, density");
    text = replaced(text, "area_m2 = 6.4516e-4\n", "");
    text = replaced(text, "length_m = 0.254, elements = 20 }",
                    "length_m = 0.2540, height_m = 0.0254, width_m = 0.0254, elements = [2, 3, 20] }");
    text = replaced(text, "[" + sign + "5.13588]", "[0.0, 0.0, " + sign + "5.1358800]");
  }
  if (solid) text = replaced(text, "model = \"bar\"", "model = \"solid\"");
  text = replaced(text, "step_s = 2.226e-6", "step_s = 1.0e-6");
  return text + "[coupling]\n" + coupling + "\n" + more;
}

class SolidBars : public testing::TestWithParam<const char*> {};

TEST_P(SolidBars, DoWhatBarsDo) {
  const TemporaryFolder folder;
  const RunResult bars = run_text(two_bodies(false, GetParam()), folder, "bars"),
                  solids = run_text(two_bodies(true, GetParam()), folder, "solids");
  ASSERT_EQ(bars.column("time_s").size(), solids.column("time_s").size());
  const double force_n = 1.33453e5, speed = 5.13588, energy_j = bars.largest("energy_kinetic_j");
  const std::pair<const char*, double> columns[] = {
      {"contact_force_n", force_n},   {"velocity_mean_left_m_s", speed}, {"velocity_mean_right_m_s", speed},
      {"energy_kinetic_j", energy_j}, {"energy_strain_j", energy_j},     {"energy_interface_j", energy_j}};
  for (const auto& [name, scale] : columns) {
    double worst = 0.0;
    for (std::size_t i = 0; i < bars.column("time_s").size(); ++i)
      worst = std::max(worst, std::abs(bars.column(name)[i] - solids.column(name)[i]) / scale);
    EXPECT_LT(worst, 1e-7) << name;
  }
  EXPECT_NEAR(solids.mean("contact_force_n", 60e-6, 140e-6), force_n, 0.01 * force_n);
}

INSTANTIATE_TEST_SUITE_P(Protocols, SolidBars,
                         testing::Values("protocol = \"hughes_liu\"", "protocol = \"kim\"",
                                         "protocol = \"kim_predicted\"", "protocol = \"belytschko_mullen\"",
                                         "protocol = \"prakash_hjelmstad\"",
                                         "protocol = \"prakash_hjelmstad\"\nsubsteps = 2",
                                         "protocol = \"gravouil_combescure\"", "protocol = \"fixed_point\"",
                                         "protocol = \"all_implicit\"", "protocol = \"all_explicit\""));

// With each law of the contact, too, whose nodes are then twelve pairs instead of one.
TEST(SolidBarsByEveryLaw, DoWhatBarsDo) {
  const TemporaryFolder folder;
  for (const std::string law : {"multiplier_update = \"massless\"", "multiplier_update = \"fully_implicit\"",
                                "enforcement = \"penalty\"\npenalty_pa_m = 1e12\nimpact_update = \"mass\""}) {
    const auto run = [&](bool solid) {
      return run_text(replaced(two_bodies(solid, ""), "[contact]\n", "[contact]\n" + law + "\n"), folder,
                      solid ? "solids" : "bars");
    };
    const RunResult bars = run(false), solids = run(true);
    for (const char* name : {"velocity_mean_left_m_s", "velocity_mean_right_m_s"}) {
      const auto &a = bars.column(name), &b = solids.column(name);
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-6) << law << ' ' << i;
    }
  }
}

constexpr double speed = 10.0, length = 0.5, size = 0.03;
const double wave_speed_m_s = std::sqrt(1e9 * 0.75 / (1000 * 1.25 * 0.5));

/// Two blocks whose sides are held meet end on: uniaxial strain, pressure rho c_L v until 2 L/c_L.
std::string blocks(const std::string& mesh, const TemporaryFolder& folder) {
  std::string text = "model = \"solid\"\n";
  for (const auto& [name, start, sign] : {std::tuple{"lower", -length, ""}, std::tuple{"upper", 0.0, "-"}}) {
    const bool tetrahedra = mesh == "tetrahedra", structured = mesh == "structured";
    if (!structured)
      (void)folder.write(block_msh(name, {.size_m = size,
                                          .start_m = start,
                                          .length_m = length,
                                          .across = 2,
                                          .along = 64,
                                          .tetrahedra = tetrahedra}),
                         std::string(name) + ".msh");
    text += fmt::format(
        "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 "
        "}}\nmesh = {{ {1} }}\ninitial_velocity_m_s = [0.0, 0.0, {2}10.0]\n",
        name,
        structured ? fmt::format("start_m = {}, length_m = {}, height_m = {}, width_m = {}, elements = [2, 2, 64]",
                                 start, length, size, size)
                   : fmt::format("gmsh = \"{}.msh\"", name),
        sign);
    for (const std::string side : {"inner", "outer", "front", "back"}) {
      if (structured)
        text += fmt::format("[[body.support]]\nsurface = \"{}\"\nfixed = [\"{}\"]\n", side,
                            side == "inner" || side == "outer" ? "x" : "y");
    }
    if (!structured) text += "[[body.support]]\nsurface = \"sides\"\nfixed = [\"x\", \"y\"]\n";
  }
  return text +
         "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n[partition]\nimplicit_length_m = { lower = 0.05, "
         "upper = 0.05 }\n[time]\nstep_s = 1.5e-6\nend_s = 1.5e-3\n";
}

class SolidPlates : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

TEST_P(SolidPlates, MeetUnderTheExactPressureAndPart) {
  const auto& [mesh, protocol] = GetParam();
  const TemporaryFolder folder;
  const RunResult r = run_text(with_protocol(blocks(mesh, folder), protocol), folder);
  const double pressure = 1000 * wave_speed_m_s * speed, period = 2.0 * length / wave_speed_m_s,
               mass = 1000 * length * size * size;
  EXPECT_NEAR(r.mean("contact_pressure_mean_pa", 0.1 * period, 0.9 * period), pressure, 0.005 * pressure);
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
  EXPECT_NEAR(r.column("contact_impulse_n_s").back(), 2.0 * mass * speed, 0.02 * 2.0 * mass * speed);
  EXPECT_NEAR(r.last("velocity_mean_lower_m_s"), -speed, 0.03 * speed);
  EXPECT_NEAR(r.last("velocity_mean_upper_m_s"), speed, 0.03 * speed);
}

INSTANTIATE_TEST_SUITE_P(
    MeshesAndProtocols, SolidPlates,
    testing::Combine(testing::Values("structured", "hexahedra", "tetrahedra"),
                     testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit")),
    [](const auto& test) { return std::string(std::get<0>(test.param)) + "_" + std::get<1>(test.param); });

/// E = rho = 1, nu = 0: a rod that an absorbing end continues, pushed or moved from its start; elements near the start
/// are a quarter as long, so that the automatic partition makes them implicit.
std::string rod(const std::string& protocol, const std::string& drive) {
  const std::string partition = protocol == "hughes_liu" ? "[partition]\nrule = \"auto\"\n" : "";
  return "model = \"solid\"\n[[body]]\nname = \"rod\"\n"
         "material = { youngs_modulus_pa = 1.0, poisson_ratio = 0.0, density_kg_m3 = 1.0 }\n"
         "mesh = { length_m = 1.0, height_m = 0.1, width_m = 0.2, elements = [2, 2, 40], grading = [1.0, 1.0, 4.0] }\n"
         "absorbing = [{ surface = \"end\", wave = \"bar\" }]\n" +
         drive + partition + "[time]\nstep_s = " + (protocol == "hughes_liu" ? "0.014" : "0.008") +
         "\nend_s = 8.0\n[coupling]\nprotocol = \"" + protocol + "\"\n";
}

class SolidRod : public testing::TestWithParam<const char*> {};

TEST_P(SolidRod, TakesUpAPushAndAPrescribedMotionAsABarWithoutEnd) {
  const TemporaryFolder folder;
  const RunResult push = run_text(
      rod(GetParam(), "traction = [{ surface = \"start\", traction_pa = [0.0, 0.0, 0.01] }]\n"), folder, "push");
  EXPECT_NEAR(push.mean("velocity_mean_rod_m_s", 4.0, 8.0), 0.01, 2e-5);
  // Displacement 0.01 t: the wave carries the same velocity.
  const RunResult moved =
      run_text(rod(GetParam(),
                   "prescribed = [{ surface = \"start\", component = \"z\", displacement_m = 0.1, amplitude = { time_s "
                   "= [0.0, 10.0], factor = [0.0, 1.0] } }]\n"),
               folder, "moved");
  EXPECT_NEAR(moved.mean("velocity_mean_rod_m_s", 4.0, 8.0), 0.01, 2e-5);
  if (std::string(GetParam()) != "hughes_liu") return;
  const auto& processes = push.summary.at("processes");
  EXPECT_EQ(processes.size(), 3U) << "the automatic partition has left something to both";
}

INSTANTIATE_TEST_SUITE_P(Protocols, SolidRod, testing::Values("hughes_liu", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

// The x-t picture: mean axial stress of layers along z, against that of bars.
TEST(SolidBarsStress, IsThatOfBars) {
  const TemporaryFolder folder;
  const auto stress = [&](bool solid) {
    const RunResult run = run_text(with_key(two_bodies(solid, ""), "output", "axial_stress_every", "1"), folder,
                                   solid ? "solids" : "bars");
    return read_history(run.folder + "/axial_stress.csv");
  };
  const History bars = stress(false), solids = stress(true);
  ASSERT_EQ(bars.size(), 41U);
  ASSERT_EQ(solids.size(), 41U);
  for (const auto& [column, values] : bars) {
    const auto& others = solids.at(column);
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_NEAR(values[i], others[i], column == "time_s" ? 0.0 : 1e-7 * 2.07e8) << column << ' ' << i;
  }
}

TEST(SolidBarsInProcesses, SpreadOverParticipantsGiveBitIdenticalHistories) {
  const TemporaryFolder folder;
  const std::string two =
      "[[participant]]\nname = \"one\"\nrole = \"explicit\"\nbodies = [\"left\"]\n[[participant]]\nname = \"other\"\n"
      "role = \"explicit\"\nbodies = [\"right\"]\n[[participant]]\nname = \"contact\"\nrole = \"implicit\"\n";
  const RunResult one = run_text(two_bodies(true, ""), folder, "one"),
                  spread = run_text(two_bodies(true, "", two), folder, "spread");
  EXPECT_TRUE(file_text(one.folder + "/history.csv") == file_text(spread.folder + "/history.csv"));
}

}  // namespace
}  // namespace ricochet::test
