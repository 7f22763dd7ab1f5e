// Bodies of pieces: meshes that share no node, tied at surfaces that lie on each other.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/both_momenta.hpp"
#include "tests/support/plane_grid.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr const char* tied_steel = "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 7800.0 }";
/// c_L of it [m/s].
const double front_speed = std::sqrt(200e9 * 0.7 / (7800.0 * 1.3 * 0.4));

std::string piece(const std::string& name, const std::string& mesh) {
  return fmt::format("[[body.mesh.piece]]\nname = \"{}\"\n{}\n", name, mesh);
}

std::string tie(const std::string& first, const std::string& second) {
  return fmt::format("[[body.mesh.tie]]\nsurfaces = [\"{}\", \"{}\"]\n", first, second);
}

std::string tied_by(const std::string& name) {
  return fmt::format("[coupling]\nprotocol = \"{}\"\n{}", name, name == "prakash_hjelmstad" ? "substeps = 2\n" : "");
}

std::string rollers(const std::vector<std::string>& surfaces, const std::string& component) {
  std::string text;
  for (const auto& surface : surfaces)
    text += fmt::format("[[body.support]]\nsurface = \"{}\"\nfixed = [\"{}\"]\n", surface, component);
  return text;
}

std::string pulled(const std::string& start, const std::string& end, int components, double traction_pa) {
  std::string text;
  for (const auto& [surface, sign] : {std::pair(start, -1.0), std::pair(end, 1.0)}) {
    std::vector<double> traction(static_cast<std::size_t>(components), 0.0);
    traction.back() = sign * traction_pa;
    text +=
        fmt::format("[[body.traction]]\nsurface = \"{}\"\ntraction_pa = [{}]\n", surface, fmt::join(traction, ", "));
  }
  return text;
}

std::string strained_state(int components, double length_m, double strain) {
  std::vector<double> end(static_cast<std::size_t>(components), 0.0);
  const std::vector<double> start = end;
  end.back() = length_m * strain;
  return fmt::format("initial_displacement_m = {{ start = [{}], end = [{}] }}\n", fmt::join(start, ", "),
                     fmt::join(end, ", "));
}

std::string steps_of(const std::string& protocol, double step_s, const std::string& implicit_piece) {
  const bool baseline = protocol.starts_with("all_") || protocol == "local_explicit";
  return (baseline ? std::string()
                   : fmt::format("[partition]\nimplicit_groups = {{ body = [\"{}\"] }}\n", implicit_piece)) +
         fmt::format("[time]\nstep_s = {}\nend_s = 5e-6\n", step_s) + tied_by(protocol);
}

constexpr double strain = 1e-4, confined_pa = 200e9 * 0.7 / (1.3 * 0.4) * strain;

/// Elements held along their sides, strained evenly by a traction on both ends: meshes of which none divides the other.
std::string strained_plane(const std::string& protocol, const std::string& implicit_piece) {
  return fmt::format("model = \"plane_strain\"\n[[body]]\nname = \"body\"\nmaterial = {}\n", tied_steel) +
         strained_state(2, 0.01, strain) + piece("low", "length_m = 0.005\nheight_m = 0.008\nelements = [5, 5]") +
         piece("high", "length_m = 0.005\nstart_m = 0.005\nheight_m = 0.008\nelements = [7, 4]\ngrading = [2.0, 1.0]") +
         tie("low.end", "high.start") + rollers({"low.inner", "low.outer", "high.inner", "high.outer"}, "x") +
         pulled("low.start", "high.end", 2, confined_pa) +
         steps_of(protocol, protocol == "all_explicit" ? 1e-8 : 4e-8, implicit_piece);
}

/// The same in space.
std::string strained_blocks(const std::string& protocol, const std::string& implicit_piece) {
  return fmt::format("model = \"solid\"\n[[body]]\nname = \"body\"\nmaterial = {}\n", tied_steel) +
         strained_state(3, 0.008, strain) +
         piece("low", "length_m = 0.004\nheight_m = 0.006\nwidth_m = 0.004\nelements = [4, 3, 3]") +
         piece("high",
               "length_m = 0.004\nheight_m = 0.006\nwidth_m = 0.004\nstart_m = 0.004\n"
               "elements = [5, 4, 3]\ngrading = [1.0, 2.0, 1.0]") +
         tie("low.end", "high.start") + rollers({"low.inner", "low.outer", "high.inner", "high.outer"}, "x") +
         rollers({"low.front", "low.back", "high.front", "high.back"}, "y") +
         pulled("low.start", "high.end", 3, confined_pa) + steps_of(protocol, 5e-8, implicit_piece);
}

/// About an axis, held at the mantle.
std::string strained_cylinder(const std::string& protocol, const std::string& implicit_piece) {
  return fmt::format("model = \"axisymmetric\"\n[[body]]\nname = \"body\"\nmaterial = {}\n", tied_steel) +
         strained_state(2, 0.01, strain) + piece("low", "length_m = 0.005\nradius_m = 0.008\nelements = [5, 5]") +
         piece("high", "length_m = 0.005\nstart_m = 0.005\nradius_m = 0.008\nelements = [7, 4]") +
         tie("high.start", "low.end") + rollers({"low.outer", "high.outer"}, "r") +
         pulled("low.start", "high.end", 2, confined_pa) + steps_of(protocol, 5e-8, implicit_piece);
}

void expect_balance(const std::string& text, const std::string& what) {
  const TemporaryFolder folder;
  const RunResult run = run_text(text, folder);
  const double stored_j = run.column("energy_strain_j").front();
  EXPECT_LT(run.largest("energy_kinetic_j"), 1e-13 * stored_j) << what;
  EXPECT_NEAR(run.last("energy_strain_j") / stored_j, 1.0, 1e-10) << what;
}

class TiedPieces : public testing::TestWithParam<const char*> {};

/// The patch test in motion: neither the tie nor the interface there pushes anything.
TEST_P(TiedPieces, StayInBalanceUnderAnEvenStrain) {
  for (const char* implicit_piece : {"low", "high"})
    expect_balance(strained_plane(GetParam(), implicit_piece), implicit_piece);
}

INSTANTIATE_TEST_SUITE_P(Protocols, TiedPieces,
                         testing::Values("hughes_liu", "kim", "belytschko_mullen", "prakash_hjelmstad",
                                         "gravouil_combescure", "fixed_point", "all_explicit", "all_implicit",
                                         "local_explicit"));

/// Where the coarser side alone ends at a motion that is given, or a support, its neighbours get no share of that.
TEST(TiedMeshes, StayInBalanceBesideAMotionThatIsGiven) {
  std::string text = strained_plane("all_implicit", "");
  for (const char* surface : {"low.outer", "high.outer"})
    text = replaced(
        text, rollers({surface}, "x"),
        fmt::format("[[body.prescribed]]\nsurface = \"{}\"\ncomponent = \"x\"\ndisplacement_m = 0.0\n", surface));
  expect_balance(replaced(text, "grading = [2.0, 1.0]", "grading = [4.0, 1.0]"), "prescribed");
}

class TiedSolids : public testing::TestWithParam<const char*> {};

TEST_P(TiedSolids, StayInBalanceUnderAnEvenStrain) {
  for (const char* implicit_piece : {"low", "high"}) {
    expect_balance(strained_blocks(GetParam(), implicit_piece), "blocks");
    expect_balance(strained_cylinder(GetParam(), implicit_piece), "cylinder");
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, TiedSolids,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_explicit", "all_implicit"));

/// A strip of elements of 1 mm with a smooth pulse over 20 of them from its start; from 0.1 m on they are of other
/// sizes.
double reflected(const std::string& protocol, const std::string& elements_behind, double finer) {
  constexpr int points = 20, pulse_elements = 20;
  std::vector<double> time_s, factor;
  for (int i = 0; i <= points; ++i) {
    time_s.push_back(pulse_elements * 1e-3 / front_speed * i / points);
    factor.push_back(std::pow(std::sin(std::acos(-1.0) * i / points), 2));
  }
  factor.back() = 0.0;
  const std::string text =
      fmt::format("model = \"plane_strain\"\n[[body]]\nname = \"strip\"\nmaterial = {}\n", tied_steel) +
      piece("before", "length_m = 0.1\nheight_m = 0.002\nelements = [2, 100]") +
      piece("behind", fmt::format("length_m = 0.1\nstart_m = 0.1\nheight_m = 0.002\nelements = {}", elements_behind)) +
      tie("before.end", "behind.start") +
      rollers({"before.inner", "before.outer", "behind.inner", "behind.outer"}, "x") +
      fmt::format(
          "[[body.traction]]\nsurface = \"before.start\"\ntraction_pa = [0.0, 1e6]\n[body.traction.amplitude]\n"
          "time_s = [{}]\nfactor = [{}]\n",
          fmt::join(time_s, ", "), fmt::join(factor, ", ")) +
      (protocol == "all_explicit" ? "" : "[partition]\nimplicit_groups = { strip = [\"behind\"] }\n") +
      fmt::format("[time]\nstep_s = {}\nend_s = {}\n",
                  (protocol == "all_explicit" ? 0.9 / finer : 0.6) * 1e-3 / front_speed, 0.17 / front_speed) +
      tied_by(protocol) + "[[output.probe]]\nname = \"before\"\nbody = \"strip\"\nat_m = [0.001, 0.05]\n";
  const TemporaryFolder folder;
  const RunResult run = run_text(text, folder);
  const History probes = read_history(run.folder + "/probes.csv");
  double there = 0.0, back = 0.0;
  for (std::size_t n = 0; n < probes.at("time_s").size(); ++n) {
    const double way_m = front_speed * probes.at("time_s")[n], v = std::abs(probes.at("before.velocity_y_m_s")[n]);
    if (way_m < 0.1) there = std::max(there, v);
    if (way_m > 0.14) back = std::max(back, v);
  }
  return back / there;
}

/// Half a per cent at most comes back of a pulse over 20 elements, whatever the ratio.
TEST(TiedStrips, ReflectLittleOfASmoothFront) {
  for (const char* protocol : {"hughes_liu", "all_explicit"}) {
    EXPECT_LT(reflected(protocol, "[3, 150]", 1.5), 5e-3) << protocol;
    EXPECT_LT(reflected(protocol, "[7, 350]", 3.5), 5e-3) << protocol;
    EXPECT_LT(reflected(protocol, "[15, 750]", 7.5), 5e-3) << protocol;
  }
}

/// A striker with a nose of 50 mm against a strip, oblique, both with a finer piece at the contact.
std::string oblique_impact(const std::string& protocol, const std::string& more = "", const std::string& body = "") {
  std::string text = "model = \"plane_strain\"\n";
  for (const bool striker : {true, false}) {
    const double low = striker ? 0.0 : 0.01, cut = striker ? 0.006 : 0.013;
    text += fmt::format("[[body]]\nname = \"{}\"\nmaterial = {}\ninitial_velocity_m_s = [{}]\n{}",
                        striker ? "striker" : "strip", tied_steel, striker ? "1.0, 10.0" : "0.0, 0.0", body);
    const auto part = [&](const char* name, double from, double to, const char* elements) {
      return piece(
          name, fmt::format("length_m = {}\nstart_m = {}\nheight_m = 0.008\nelements = {}", to - from, from, elements));
    };
    text += part("low", low, cut, striker ? "[8, 6]" : "[19, 7]") +
            part("high", cut, low + 0.01, striker ? "[21, 9]" : "[8, 7]") + tie("low.end", "high.start");
  }
  return text + "[contact]\nsurfaces = [\"striker.high.end\", \"strip.low.start\"]\nnose_radius_m = 0.05\n" +
         "friction_coefficient = 0.2\n[time]\nend_s = 8e-6\n" +
         (protocol == "all_explicit" ? "safety_factor = 0.5\n" : "step_s = 8e-8\n") + more + tied_by(protocol);
}

class TiedImpact : public testing::TestWithParam<const char*> {};

TEST_P(TiedImpact, KeepsBothMomenta) {
  const TemporaryFolder folder;
  const RunResult run = run_text(oblique_impact(GetParam()), folder),
                  reference = run_text(oblique_impact("all_implicit"), folder, "reference");
  expect_both_momenta(run, reference, 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Protocols, TiedImpact,
                         testing::Values("hughes_liu", "belytschko_mullen", "prakash_hjelmstad", "fixed_point",
                                         "all_explicit", "local_explicit"));

/// The impact of the same elements on one mesh, but for the error of the change of size.
TEST(TiedImpact, IsThatOfTheUntiedMesh) {
  const TemporaryFolder folder;
  std::string one = oblique_impact("all_implicit");
  for (std::size_t at = one.find("[8, 6]"); at != std::string::npos; at = one.find("[8, 6]"))
    one.replace(at, 6, "[21, 12]");
  one = replaced(replaced(one, "[19, 7]", "[19, 5]"), "[8, 7]", "[19, 11]");
  const RunResult tied = run_text(oblique_impact("all_implicit"), folder, "tied"), fine = run_text(one, folder, "fine");
  EXPECT_NEAR(tied.last("contact_impulse_n_s") / fine.last("contact_impulse_n_s"), 1.0, 0.01);
  EXPECT_NEAR(tied.largest("contact_force_n") / fine.largest("contact_force_n"), 1.0, 0.02);
}

TEST(TiedImpact, GoesOnFromACheckpoint) {
  const TemporaryFolder folder;
  const RunResult run = run_text(oblique_impact("hughes_liu", "[checkpoint]\nevery_windows = 40\n"), folder);
  expect_the_same_from_the_earlier_checkpoint(run, folder);
}

/// A plate of three pieces spins as one.
TEST(TiedPlate, SpinsAndKeepsItsMomentaAndItsEnergy) {
  const TemporaryFolder folder;
  const RunResult run = run_text(
      fmt::format("model = \"plane_strain\"\n[[body]]\nname = \"plate\"\nmaterial = {}\nlarge_rotation = true\n"
                  "initial_angular_velocity_rad_s = 3000.0\ninitial_velocity_m_s = [10.0, 3.0]\n",
                  tied_steel) +
          piece("one", "length_m = 0.02\nheight_m = 0.02\nelements = [4, 4]") +
          piece("two", "length_m = 0.02\nstart_m = 0.02\nheight_m = 0.02\nelements = [7, 7]") +
          piece("three", "length_m = 0.02\nstart_m = 0.04\nheight_m = 0.02\nelements = [5, 5]") +
          tie("one.end", "two.start") + tie("three.start", "two.end") +
          "[time]\nsafety_factor = 0.7\nend_s = 2e-3\n[output]\nhistory_every = 40\n" + tied_by("all_explicit"),
      folder);
  EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-12);
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-12);
  EXPECT_LT(run.summary["energy_error_max"].get<double>(), 1e-5);
}

/// A cantilever (Norma's: 254 mm, E 6.895 GPa) of two meshes at 6 : 7 and 6 : 9, one of them in four substeps a window,
/// under a pulse across: the interface and the tie leave the energy in a millisecond what it is to 1e-3.
TEST(TiedCantilever, KeepsItsEnergyWithFourSubsteps) {
  for (const int elements : {7, 9}) {
    for (const char* implicit_piece : {"root", "tip"}) {
      const bool tip = std::string(implicit_piece) == "tip";
      const double size_m = 0.0254 / (tip ? 6 : elements), speed = std::sqrt(6.895e9 * 0.75 / (2768.0 * 1.25 * 0.5));
      const std::string text =
          "model = \"solid\"\n[[body]]\nname = \"beam\"\n"
          "material = { youngs_modulus_pa = 6.895e9, poisson_ratio = 0.25, density_kg_m3 = 2768.0 }\n" +
          piece("root", "length_m = 0.127\nheight_m = 0.0254\nwidth_m = 0.0254\nelements = [6, 6, 30]") +
          piece("tip", fmt::format("length_m = 0.127\nstart_m = 0.127\nheight_m = 0.0254\nwidth_m = 0.0254\n"
                                   "elements = [{0}, {0}, {1}]",
                                   elements, 5 * elements)) +
          tie("root.end", "tip.start") + "[[body.support]]\nsurface = \"root.start\"\nfixed = [\"x\", \"y\", \"z\"]\n" +
          "[[body.traction]]\nsurface = \"tip.end\"\ntraction_pa = [1e3, 0.0, 0.0]\n[body.traction.amplitude]\n" +
          "time_s = [0.0, 1e-4, 2e-4]\nfactor = [0.0, 1.0, 0.0]\n" +
          fmt::format(
              "[partition]\nimplicit_groups = {{ beam = [\"{}\"] }}\n[time]\nstep_s = {}\nend_s = 1e-3\n"
              "[coupling]\nprotocol = \"prakash_hjelmstad\"\nsubsteps = 4\n[output]\nhistory_every = 5\n",
              implicit_piece, 4 * 0.55 * size_m / speed);
      const TemporaryFolder folder;
      const RunResult run = run_text(text, folder);
      EXPECT_LT(run.summary["energy_error_max"].get<double>(), 1e-3) << elements << ", implicit " << implicit_piece;
      EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-10);
    }
  }
}

/// A bar of two pieces is the bar.
TEST(TiedBars, AreOneBar) {
  const TemporaryFolder folder;
  const auto bars = [](const std::string& mesh) {
    return fmt::format(
        "model = \"bar\"\n[[body]]\nname = \"bar\"\nmaterial = {}\ninitial_velocity_m_s = [10.0]\n{}"
        "[contact]\nsurfaces = [\"bar.{}end\", \"rigid_plane\"]\n[time]\nstep_s = 2e-8\nend_s = 1.5e-5\n",
        tied_steel, mesh, mesh.starts_with("[[") ? "b." : "");
  };
  const RunResult whole = run_text(bars("[body.mesh]\nlength_m = 0.02\nelements = 40\n"), folder, "whole"),
                  tied = run_text(
                      bars(piece("a", "length_m = 0.01\nelements = 20") +
                           piece("b", "length_m = 0.01\nstart_m = 0.01\nelements = 20") + tie("a.end", "b.start")),
                      folder, "tied");
  const auto &force = tied.column("contact_force_n"), &expected = whole.column("contact_force_n");
  ASSERT_EQ(force.size(), expected.size());
  for (std::size_t n = 0; n < force.size(); ++n)
    ASSERT_NEAR(force[n], expected[n], 1e-9 * whole.largest("contact_force_n")) << n;
}

/// A shaft that stands on a plate takes hold of the part of it that it covers. Both are pulled apart by one force.
TEST(TiedMeshes, MayCoverAPartOfTheOtherSurface) {
  const TemporaryFolder folder;
  const double shaft_m2 = 3.0 * 36 * std::pow(0.006, 2) * std::sin(std::acos(-1.0) / 12) / 9.0;  // of 24 corners
  const RunResult run =
      run_text(fmt::format("model = \"solid\"\n[[body]]\nname = \"pin\"\nmaterial = {}\n", tied_steel) +
                   piece("plate",
                         "length_m = 0.004\nheight_m = 0.02\nwidth_m = 0.02\nelements = [10, 10, 2]\n"
                         "place = { moved_m = [-0.01, -0.01, 0.0] }") +
                   piece("shaft", "length_m = 0.02\nstart_m = 0.004\nradius_m = 0.006\nelements = [6, 10]") +
                   tie("plate.end", "shaft.start") +
                   fmt::format("[[body.traction]]\nsurface = \"plate.start\"\ntraction_pa = [0.0, 0.0, {}]\n"
                               "[[body.traction]]\nsurface = \"shaft.end\"\ntraction_pa = [0.0, 0.0, 1e6]\n",
                               -1e6 * shaft_m2 / 4e-4) +
                   "[time]\nstep_s = 1e-7\nend_s = 4e-5\n" + tied_by("all_explicit"),
               folder);
  EXPECT_LT(run.summary["energy_error_max"].get<double>(), 1e-2);
  // Neither of the two flies away: the shaft is strained and vibrates.
  const double force_n = 1e6 * shaft_m2, free_j = std::pow(force_n * 4e-5, 2) / (2.0 * 7800.0 * shaft_m2 * 0.02);
  EXPECT_LT(run.last("energy_kinetic_j"), 0.02 * free_j);
  EXPECT_GT(run.last("energy_strain_j"), force_n * force_n * 0.02 / (2.0 * 200e9 * shaft_m2));
}

/// A probe beside a tie takes its share from the nodes that carry those around it.
TEST(TiedMeshes, ShowAProbeBesideATie) {
  const TemporaryFolder folder;
  const RunResult run = run_text(strained_plane("hughes_liu", "low") +
                                     "[[output.probe]]\nname = \"beside\"\nbody = \"body\"\nat_m = [0.0035, 0.0052]\n",
                                 folder);
  const History probes = read_history(run.folder + "/probes.csv");
  EXPECT_NEAR(probes.at("beside.displacement_y_m").back(), 0.0052 * strain, 1e-9 * 0.0052);
  EXPECT_NEAR(probes.at("beside.stress_yy_pa").back() / confined_pa, 1.0, 1e-6);
}

/// A study or --set names a piece.
TEST(TiedMeshes, HaveKeysOfTheirOwn) {
  const TemporaryFolder folder;
  const std::string scene = folder.write(strained_plane("all_explicit", "low"));
  const Outcome outcome =
      run_command({ricochet_binary(), "check", scene, "--set", "body.body.mesh.piece.high.elements=[9, 4]"},
                  folder.path().string(), 60.0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr(" 61 "));
}

TEST(TiedMeshes, SayWhichNodesStayFree) {
  const TemporaryFolder folder;
  const std::string moved = replaced(strained_plane("all_explicit", ""), "elements = [7, 4]\ngrading = [2.0, 1.0]",
                                     "elements = [8, 4]\nplace = { moved_m = [0.0025, 0.0] }");
  const Outcome outcome = run_command({ricochet_binary(), "check", folder.write(moved)}, folder.path().string(), 60.0);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr("note: body \"body\": 3 of the 9 nodes of \"high.start\" lie beside \"low.end\", "
                                     "to which it is tied, and stay free"));
  // The rim of a fine disc stands off that of a coarse one; all of it holds.
  const std::string discs = fmt::format("model = \"solid\"\n[[body]]\nname = \"rod\"\nmaterial = {}\n", tied_steel) +
                            piece("coarse", "length_m = 0.01\nradius_m = 0.005\nelements = [3, 3]") +
                            piece("fine", "length_m = 0.01\nstart_m = 0.01\nradius_m = 0.005\nelements = [7, 6]") +
                            tie("coarse.end", "fine.start") + "[time]\nstep_s = 1e-8\nend_s = 1e-6\n" +
                            tied_by("all_explicit");
  const Outcome held = run_command({ricochet_binary(), "check", folder.write(discs)}, folder.path().string(), 60.0);
  EXPECT_EQ(held.code, 0) << held.error;
  EXPECT_THAT(held.out, testing::Not(HasSubstr("stay free")));
}

/// Curved surfaces with the same faces are tied node to node: two half rings are the ring.
TEST(TiedMeshes, OfTheSameFacesAreOneMesh) {
  const TemporaryFolder folder;
  const auto ring = [](double inner_m, double outer_m, int layers) {
    return PlaneGrid(10, layers, [=](double a, double b) {
      const double angle = (a - 0.5) * 2.0, radius = inner_m + (outer_m - inner_m) * b;
      return PlaneGrid::Place(radius * std::sin(angle), 0.02 - radius * std::cos(angle));
    });
  };
  const auto write = [&](const std::string& name, const PlaneGrid& grid) {
    (void)folder.write(grid.msh(name, {{"in", grid.low()}, {"out", grid.high()}}), name + ".msh");
  };
  write("ring", ring(0.012, 0.02, 8));
  write("inner", ring(0.012, 0.016, 4));
  write("outer", ring(0.016, 0.02, 4));
  const auto scene = [](const std::string& mesh, const std::string& surface) {
    return fmt::format(
               "model = \"plane_strain\"\n[[body]]\nname = \"ring\"\nmaterial = {}\n"
               "initial_velocity_m_s = [0.0, -5.0]\n{}[contact]\nsurfaces = [\"ring.{}\", \"rigid_plane\"]\n"
               "[time]\nstep_s = 5e-8\nend_s = 1e-5\n",
               tied_steel, mesh, surface) +
           tied_by("all_implicit");
  };
  const RunResult whole = run_text(scene("[body.mesh]\ngmsh = \"ring.msh\"\n", "out"), folder, "whole"),
                  tied = run_text(scene(piece("inner", "gmsh = \"inner.msh\"") +
                                            piece("outer", "gmsh = \"outer.msh\"") + tie("inner.out", "outer.in"),
                                        "outer.out"),
                                  folder, "tied");
  const auto &force = tied.column("contact_force_n"), &expected = whole.column("contact_force_n");
  ASSERT_EQ(force.size(), expected.size());
  for (std::size_t n = 0; n < force.size(); ++n)
    ASSERT_NEAR(force[n], expected[n], 1e-8 * whole.largest("contact_force_n")) << n;
  EXPECT_GT(whole.largest("contact_force_n"), 0.0);
}

TEST(WrongTies, AreRefusedByName) {
  const std::string plane = strained_plane("all_explicit", "");
  const std::string tied = tie("low.end", "high.start");
  EXPECT_THAT(check_refusal(replaced(plane, tied, tie("low.end", "high.strat"))),
              HasSubstr("body.body.mesh.tie[0].surfaces: found \"high.strat\"; did you mean \"high.start\"?"));
  EXPECT_THAT(check_refusal(replaced(plane, tied, "")),
              HasSubstr("found piece \"high\", which no tie joins to \"low\"; allowed: pieces that [[body.mesh.tie]]"));
  EXPECT_THAT(check_refusal(replaced(plane, "start_m = 0.005", "start_m = 0.0051")),
              HasSubstr("found \"high.start\" 0.0001 m away from \"low.end\" at (0, 0.0051) m"));
  EXPECT_THAT(check_refusal(replaced(plane, tied, tie("low.start", "high.start"))),
              HasSubstr("\"low.start\", which lie nowhere opposite each other"));
  EXPECT_THAT(check_refusal(replaced(plane, tied, tied + tied)), HasSubstr("which hangs already"));
  EXPECT_THAT(check_refusal(replaced(plane, "name = \"high\"", "name = \"low\"")), HasSubstr("\"low\" a second time"));
  EXPECT_THAT(check_refusal(replaced(plane, "surfaces = [\"low.end\", \"high.start\"]", "surfaces = [\"low.end\"]")),
              HasSubstr("found 1 surfaces; allowed: two, each \"PIECE.SURFACE\""));
  EXPECT_THAT(check_refusal(replaced(plane, "[[body.mesh.piece]]\nname = \"low\"",
                                     "[body.mesh]\nlength_m = 1.0\n[[body.mesh.piece]]\nname = \"low\"")),
              HasSubstr("each [[body.mesh.piece]] has keys of its own"));
  EXPECT_THAT(check_refusal(replaced(plane, "elements = [5, 5]", "elements = [5, 5]\nperiodic_across = true")),
              HasSubstr("a mesh without pieces"));
}

}  // namespace
}  // namespace ricochet::test
