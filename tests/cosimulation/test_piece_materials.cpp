// Pieces of one body with materials of their own.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr double steel_pa = 200e9, steel_kg_m3 = 8000.0, plastic_pa = 5e9, plastic_kg_m3 = 1250.0;
const double steel_speed = std::sqrt(steel_pa / steel_kg_m3), plastic_speed = std::sqrt(plastic_pa / plastic_kg_m3);

std::string layer(const std::string& name, double from_m, double to_m, const std::string& elements,
                  const std::string& material, const std::string& more = "") {
  return fmt::format(
      "[[body.mesh.piece]]\nname = \"{}\"\nmaterial = {}\nlength_m = {}\nstart_m = {}\nelements = {}\n{}", name,
      material, to_m - from_m, from_m, elements, more);
}

std::string elastic(double young_pa, double density_kg_m3) {
  return fmt::format("{{ youngs_modulus_pa = {}, poisson_ratio = 0.0, density_kg_m3 = {} }}", young_pa, density_kg_m3);
}

std::string joined(const std::string& first, const std::string& second) {
  return fmt::format("[[body.mesh.tie]]\nsurfaces = [\"{}\", \"{}\"]\n", first, second);
}

/// A smooth pulse of 40 us from the start of steel that meets plastic at 0.5 m.
std::string pulse_on(const std::string& model, const std::string& across, const std::string& more) {
  constexpr int points = 40;
  std::vector<double> time_s, factor;
  for (int i = 0; i <= points; ++i) {
    time_s.push_back(40e-6 * i / points);
    factor.push_back(std::pow(std::sin(std::acos(-1.0) * i / points), 2));
  }
  factor.back() = 0.0;
  const bool bar = model == "bar";
  const auto elements = [&](int wide, int along) {
    return bar ? fmt::format("{}", along) : fmt::format("[{}, {}]", wide, along);
  };
  return fmt::format("model = \"{}\"\n[[body]]\nname = \"rod\"\n", model) +
         layer("steel", 0.0, 0.5, elements(2, 250), elastic(steel_pa, steel_kg_m3), across) +
         layer("plastic", 0.5, 0.7, elements(5, 250), elastic(plastic_pa, plastic_kg_m3), across) +
         joined("steel.end", "plastic.start") +
         fmt::format(
             "[[body.traction]]\nsurface = \"steel.start\"\ntraction_pa = [{}1e6]\n[body.traction.amplitude]\n"
             "time_s = [{}]\nfactor = [{}]\n",
             bar ? "" : "0.0, ", fmt::join(time_s, ", "), fmt::join(factor, ", ")) +
         "[[output.probe]]\nname = \"before\"\nbody = \"rod\"\nat_m = [" + (bar ? "" : "0.0, ") +
         "0.25]\n[[output.probe]]\nname = \"behind\"\nbody = \"rod\"\nat_m = [" + (bar ? "" : "0.0, ") + "0.6]\n" +
         more;
}

/// Largest of a column by size, with its sign, between two times.
double peak(const History& history, const std::string& column, double from_s, double to_s) {
  double found = 0.0;
  for (std::size_t n = 0; n < history.at("time_s").size(); ++n) {
    const double time = history.at("time_s")[n], value = history.at(column)[n];
    if (time >= from_s && time <= to_s && std::abs(value) > std::abs(found)) found = value;
  }
  return found;
}

class Layers : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

/// Where impedances Z = rho c differ, stress comes back (Z2 - Z1)/(Z2 + Z1) times, and goes on 2 Z2/(Z1 + Z2) times.
TEST_P(Layers, ReflectAsTheirImpedancesSay) {
  const auto& [model, protocol] = GetParam();
  const bool bar = std::string(model) == "bar", baseline = std::string(protocol).starts_with("all_");
  std::string more = fmt::format("[time]\nstep_s = 2e-7\nend_s = 1.95e-4\n[coupling]\nprotocol = \"{}\"\n{}", protocol,
                                 std::string(protocol) == "prakash_hjelmstad" ? "substeps = 2\n" : "");
  if (!baseline) more = "[partition]\nimplicit_groups = { rod = [\"plastic\"] }\n" + more;
  const TemporaryFolder folder;
  const RunResult run = run_text(pulse_on(model, bar ? "" : "height_m = 0.004\n", more), folder);
  const History probes = read_history(run.folder + "/probes.csv");
  const std::string stress = bar ? "stress_xx_pa" : "stress_yy_pa";
  const double there = 0.25 / steel_speed, middle = 0.5 / steel_speed, back = 0.75 / steel_speed, long_s = 40e-6;
  const double sent = peak(probes, "before." + stress, there, there + long_s),
               returned = peak(probes, "before." + stress, back, back + long_s),
               went_on = peak(probes, "behind." + stress, middle + 0.1 / plastic_speed,
                              middle + 0.1 / plastic_speed + long_s);
  const double z1 = steel_kg_m3 * steel_speed, z2 = plastic_kg_m3 * plastic_speed;
  EXPECT_NEAR(returned / sent, (z2 - z1) / (z2 + z1), 0.01);
  EXPECT_NEAR(went_on / sent, 2.0 * z2 / (z1 + z2), 0.002);
}

INSTANTIATE_TEST_SUITE_P(Models, Layers,
                         testing::Combine(testing::Values("bar", "plane_strain"),
                                          testing::Values("hughes_liu", "prakash_hjelmstad", "all_explicit",
                                                          "all_implicit")));

/// The rod of pulse_on("bar") as one mesh with two element sets; `more`: cards.
std::string rod_inp(const std::string& more = "") {
  std::string text = "*NODE\n";
  for (int i = 0; i <= 500; ++i)
    text += fmt::format("{}, {:.17g}, 0.0, 0.0\n", i + 1, i <= 250 ? 0.5 * i / 250 : 0.5 + 0.2 * (i - 250) / 250);
  for (const auto& [name, first] : {std::pair("STEEL", 1), std::pair("PLASTIC", 251)}) {
    text += fmt::format("*ELEMENT, TYPE=T3D2, ELSET={}\n", name);
    for (int e = first; e < first + 250; ++e) text += fmt::format("{}, {}, {}\n", e, e, e + 1);
  }
  return text + "*ELSET, ELSET=ROD, GENERATE\n1, 500, 1\n*SURFACE, NAME=START\n1, END1\n" + more;
}

std::string grouped_rod(const std::string& groups) {
  std::string text =
      pulse_on("bar", "", "[time]\nstep_s = 2e-7\nend_s = 1.95e-4\n[coupling]\nprotocol = \"all_implicit\"\n");
  const auto first = text.find("[[body.mesh.piece]]"), last = text.find("[[body.traction]]");
  text = text.substr(0, first) + "material = " + elastic(steel_pa, steel_kg_m3) + "\nmesh = { inp = \"rod.inp\" }\n" +
         groups + text.substr(last);
  return replaced(text, "\"steel.start\"", "\"START\"");
}

std::string group(const std::string& name, const std::string& material) {
  return fmt::format("[[body.group]]\nname = \"{}\"\nmaterial = {}\n", name, material);
}

/// Materials by element groups of one mesh are those of pieces with the same nodes.
TEST(GroupMaterials, AreThoseOfPieces) {
  const TemporaryFolder folder;
  (void)folder.write(rod_inp(), "rod.inp");
  const RunResult pieces = run_text(
                      pulse_on("bar", "",
                               "[time]\nstep_s = 2e-7\nend_s = 1.95e-4\n[coupling]\nprotocol = \"all_implicit\"\n"),
                      folder, "pieces"),
                  groups =
                      run_text(grouped_rod(group("PLASTIC", elastic(plastic_pa, plastic_kg_m3))), folder, "groups");
  const auto &strain = groups.column("energy_strain_j"), &expected = pieces.column("energy_strain_j");
  ASSERT_EQ(strain.size(), expected.size());
  for (std::size_t n = 0; n < strain.size(); ++n)
    ASSERT_NEAR(strain[n], expected[n], 1e-10 * pieces.largest("energy_strain_j")) << n;
}

TEST(GroupMaterials, AreRefusedByName) {
  const auto refused = [](const std::string& text, const std::string& cards = "") {
    const TemporaryFolder folder;
    (void)folder.write(rod_inp(cards), "rod.inp");
    const Outcome outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string(), 60.0);
    EXPECT_EQ(outcome.code, 2);
    return outcome.error;
  };
  const std::string plastic = elastic(plastic_pa, plastic_kg_m3);
  EXPECT_THAT(refused(grouped_rod(group("PLASTICS", plastic))),
              HasSubstr("body.rod.group.PLASTICS: found group \"PLASTICS\"; did you mean \"PLASTIC\"?"));
  EXPECT_THAT(refused(grouped_rod(group("PLASTIC", plastic) + group("PLASTIC", plastic))), HasSubstr("a second time"));
  EXPECT_THAT(refused(grouped_rod(group("PLASTIC", plastic) + group("TIP", plastic)), "*ELSET, ELSET=TIP\n500\n"),
              HasSubstr("found an element of group \"PLASTIC\", too; allowed: groups that share no element"));
  EXPECT_THAT(refused(replaced(grouped_rod(group("PLASTIC", plastic)), "mesh = { inp = \"rod.inp\" }",
                               "mesh = { length_m = 0.7, elements = 7 }")),
              HasSubstr("only with a body of pieces or read from a mesh file"));
}

/// `check` weighs each piece by its own density; the wave that bounds the step is the faster one.
TEST(PieceMaterials, MakeTheMassAndTheCriticalStep) {
  const TemporaryFolder folder;
  const std::string text =
      pulse_on("bar", "", "[time]\nstep_s = 2e-7\nend_s = 1e-5\n[coupling]\nprotocol = \"all_explicit\"\n");
  const Outcome outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string(), 60.0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr(fmt::format("{:.4g}", 0.5 * steel_kg_m3 + 0.2 * plastic_kg_m3)));
  EXPECT_THAT(outcome.out, HasSubstr(" 0.7 "));  // its volume [m^3], at 1 m^2
  EXPECT_THAT(outcome.out, HasSubstr(" 4e-07\n")) << "2 mm over the speed in steel, 0.8 mm over that in plastic";
}

/// A rod of a hard and a soft piece, pulled slowly up to 300 MPa; about an axis its mantle is held.
std::string pulled_rod(const std::string& model, const std::string& more) {
  const bool bar = model == "bar";
  const std::string flows =
      "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.0, density_kg_m3 = 8000.0, plasticity = { yield_stress_pa = "
      "200e6, hardening_pa = 20e9 } }";
  const auto elements = [&](int wide) { return bar ? std::string("10") : fmt::format("[{}, 10]", wide); };
  const std::string across = bar ? "" : "radius_m = 0.004\n";
  return fmt::format("model = \"{}\"\n[[body]]\nname = \"rod\"\nmaterial = {}\n", model, elastic(400e9, 16000.0)) +
         replaced(layer("hard", 0.0, 0.01, elements(3), "\"\"", across), "material = \"\"\n", "") +
         layer("soft", 0.01, 0.02, elements(4), flows, across) + joined("hard.end", "soft.start") +
         (bar ? ""
              : "[[body.support]]\nsurface = \"hard.outer\"\nfixed = [\"r\"]\n[[body.support]]\nsurface = "
                "\"soft.outer\"\nfixed = [\"r\"]\n") +
         fmt::format("[[body.support]]\nsurface = \"hard.start\"\nfixed = [\"{}\"]\n", bar ? "x" : "z") +
         fmt::format(
             "[[body.traction]]\nsurface = \"soft.end\"\ntraction_pa = [{}300e6]\n[body.traction.amplitude]\n"
             "time_s = [0.0, 4e-4]\nfactor = [0.0, 1.0]\n",
             bar ? "" : "0.0, ") +
         fmt::format(
             "[[output.probe]]\nname = \"hard\"\nbody = \"rod\"\nat_m = [{0}0.0055]\n[[output.probe]]\nname = "
             "\"soft\"\nbody = \"rod\"\nat_m = [{0}0.0155]\n",
             bar ? "" : "0.001, ") +
         more;
}

class PieceThatYields : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

/// With stress sigma along the rod, yield stress y, hardening h and equivalent plastic strain p: sigma = y + h p of a
/// bar; where no strain across is let, plastic strain -p/2 there makes a stress E p/2, and sigma - E p/2 = y + h p.
TEST_P(PieceThatYields, FlowsAlone) {
  const auto& [model, protocol] = GetParam();
  const bool bar = std::string(model) == "bar";
  std::string more = fmt::format("[time]\nstep_s = 1e-7\nend_s = 4e-4\n[coupling]\nprotocol = \"{}\"\n", protocol);
  if (!std::string(protocol).starts_with("all_")) more = "[partition]\nimplicit_groups = { rod = [\"hard\"] }\n" + more;
  const TemporaryFolder folder;
  const RunResult run = run_text(pulled_rod(model, more), folder);
  const History probes = read_history(run.folder + "/probes.csv");
  const double flowed = (300e6 - 200e6) / (bar ? 20e9 : 120e9), mean_pa = 200e6 + 0.5 * 20e9 * flowed;
  EXPECT_NEAR(probes.at("soft.equivalent_plastic_strain").back(), flowed, 0.02 * flowed);
  EXPECT_EQ(probes.at("hard.equivalent_plastic_strain").back(), 0.0);
  EXPECT_NEAR(probes.at(bar ? "hard.strain_xx" : "hard.strain_zz").back(), 300e6 / 400e9, 0.02 * 300e6 / 400e9);
  EXPECT_NEAR(probes.at(bar ? "hard.stress_xx_pa" : "hard.stress_zz_pa").back(), 300e6,
              0.02 * 300e6);  // it rings by 1 %
  EXPECT_LT(run.summary["energy_error_max"].get<double>(), 1e-3);
  const double volume_m3 = 0.01 * (bar ? 1.0 : std::acos(-1.0) * 16e-6);
  EXPECT_NEAR(run.last("plastic_work_j") / (volume_m3 * mean_pa * flowed), 1.0, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Models, PieceThatYields,
                         testing::Combine(testing::Values("bar", "axisymmetric"),
                                          testing::Values("hughes_liu", "all_explicit", "all_implicit")));

TEST(PieceMaterials, GoOnFromACheckpointWhileOneYields) {
  const TemporaryFolder folder;
  const RunResult run =
      run_text(pulled_rod("axisymmetric",
                          "[partition]\nimplicit_groups = { rod = [\"soft\"] }\n[time]\nstep_s = 1e-7\nend_s = 3.6e-4\n"
                          "[coupling]\nprotocol = \"hughes_liu\"\n[checkpoint]\nevery_windows = 1800\n"),
               folder);
  EXPECT_GT(run.last("plastic_work_j"), 0.0);
  expect_the_same_from_the_earlier_checkpoint(run, folder);
}

/// The watch compares each element with the limit of its own material.
TEST(PieceMaterials, HaveLimitsOfTheirOwn) {
  const TemporaryFolder folder;
  std::string text =
      pulled_rod("axisymmetric", "[time]\nstep_s = 1e-7\nend_s = 4e-4\n[coupling]\nprotocol = \"all_explicit\"\n");
  text = replaced(text, ", plasticity = { yield_stress_pa = 200e6, hardening_pa = 20e9 } }",
                  ", yield_stress_pa = 250e6 }");
  text = replaced(text, "density_kg_m3 = 16000 }", "density_kg_m3 = 16000, yield_stress_pa = 1e9 }");
  const RunResult run = run_text(text, folder);
  const auto& outside = run.summary["outside_model"];
  ASSERT_EQ(outside.size(), 1U);
  EXPECT_EQ(outside[0]["kind"], "yield");
  EXPECT_GT(outside[0]["place_m"][1].get<double>(), 0.01) << "in the soft piece";
  EXPECT_THAT(run.outcome.error + run.outcome.out, HasSubstr("its yield stress of 250 MPa"));
  ASSERT_EQ(run.summary["limits"].size(), 2U);
  EXPECT_EQ(run.summary["limits"][0]["body"], "rod.hard");
  EXPECT_EQ(run.summary["limits"][1]["yield_stress_pa"], 250e6);
}

TEST(PieceMaterials, AreRefusedWhereTheyCannotBe) {
  const auto refused = [](const std::string& text) {
    const TemporaryFolder folder;
    const Outcome outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string(), 60.0);
    EXPECT_EQ(outcome.code, 2);
    return outcome.error;
  };
  const std::string text =
      pulse_on("bar", "", "[time]\nstep_s = 2e-7\nend_s = 1e-5\n[coupling]\nprotocol = \"all_explicit\"\n");
  const std::string own = "material = " + elastic(plastic_pa, plastic_kg_m3) + "\n";
  EXPECT_THAT(refused(replaced(text, own, "")), HasSubstr("body.rod.material: found nothing"));
  EXPECT_THAT(refused(replaced(text, own, "material = \"lead\"\n")),
              HasSubstr("body.rod.mesh.piece.plastic.material: found \"lead\""));
  EXPECT_THAT(refused(text + "[contact]\nsurfaces = [\"rod.plastic.end\", \"rigid_plane\"]\nenforcement = \"penalty\"\n"
                             "penalty_pa_m = 1e12\nimpact_update = \"impedance\"\n"),
              HasSubstr("impedance"));
}

}  // namespace
}  // namespace ricochet::test
