#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/support/block_mesh.hpp"
#include "tests/support/run.hpp"

// Meshes of Abaqus and CalculiX input files, in whole runs.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr BlockMesh rod{0.01, 0.0, 0.1, 2, 20};

/// The mesh of block_msh as an input file, of hexahedra that are not turned.
std::string block_inp(const BlockMesh& b) {
  const int row = b.across + 1, layer = row * row, cells = b.across * b.across * b.along, first = b.across * b.across;
  std::string text = "*HEADING\nrod\n*NODE, NSET=all\n";
  for (int n = 0; n < layer * (b.along + 1); ++n)
    text += fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", n + 1, b.size_m * (n % row) / b.across,
                        b.size_m * (n % layer / row) / b.across, b.start_m + b.length_m * (n / layer) / b.along);
  text += "*ELEMENT, TYPE=C3D8, ELSET=ROD\n";
  for (int cell = 0; cell < cells; ++cell) {
    const int n = 1 + cell / first * layer + cell / b.across % b.across * row + cell % b.across;
    text += fmt::format("{}, {}, {}, {}, {},\n{}, {}, {}, {}\n", cell + 1, n, n + 1, n + row + 1, n + row, n + layer,
                        n + layer + 1, n + layer + row + 1, n + layer + row);
  }
  return text + fmt::format(
                    "*NSET, NSET=held, GENERATE\n1, {}, 1\n*ELSET, ELSET=first, GENERATE\n1, {}, 1\n"
                    "*ELSET, ELSET=last, GENERATE\n{}, {}, 1\n*SURFACE, NAME=start, TYPE=ELEMENT\nfirst, S1\n"
                    "*SURFACE, NAME=end, TYPE=ELEMENT\nlast, S2\n",
                    layer, first, cells - first + 1, cells);
}

/// A rod that is held at its start and pressed at its end; the pressure grows for 20 us.
std::string pressed_rod(const std::string& mesh, const std::string& held = "start") {
  return R"(model = "solid"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }
mesh = { )" +
         mesh + " }\nsupport = [{ surface = \"" + held + R"(", fixed = ["x", "y", "z"] }]
traction = [{ surface = "end", pressure_pa = 1e7, amplitude = { time_s = [0.0, 2e-5], factor = [0.0, 1.0] } }]
[time]
step_s = 4e-7
end_s = 8e-5
[coupling]
protocol = "all_explicit"
)";
}

std::vector<double> energies_of(const std::string& calculix_text) {
  std::istringstream lines(calculix_text);
  std::vector<double> energies;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    double value = 0.0;
    if (words >> value && (words >> std::ws).eof()) energies.push_back(value);
  }
  return energies;
}

/// One file for both: CalculiX reads its material, support, load and step, which ricochet leaves to the scene. Their
/// elements differ (CalculiX has B-bar and consistent masses), so that the energies agree to 1 % of the largest.
TEST(AbaqusFiles, AreRunByCalculixWithTheSameAnswer) {
  const TemporaryFolder folder;
  (void)folder.write(block_inp(rod) + R"(*MATERIAL, NAME=steel
*ELASTIC
2e11, 0.3
*DENSITY
8000.
*SOLID SECTION, ELSET=ROD, MATERIAL=steel
*BOUNDARY
held, 1, 3
*AMPLITUDE, NAME=ramp
0., 0., 2e-5, 1., 1., 1.
*STEP, INC=1000
*DYNAMIC, DIRECT, ALPHA=0.
4e-7, 8e-5
*DLOAD, AMPLITUDE=ramp
last, P2, 1e7
*EL PRINT, ELSET=ROD, TOTALS=ONLY, FREQUENCY=1
ELSE
*END STEP
)",
                     "rod.inp");
  const auto run = run_text(pressed_rod("inp = \"rod.inp\""), folder, "ricochet");
  const auto calculix =
      run_command({"/bin/sh", "-c", "ccx -i " + (folder.path() / "rod").string()}, folder.path().string());
  if (calculix.code == 127) GTEST_SKIP() << "CalculiX is not installed (Debian's calculix-ccx)";
  ASSERT_EQ(calculix.code, 0) << calculix.out;
  const std::vector<double> theirs = energies_of(file_text((folder.path() / "rod.dat").string()));
  const std::vector<double>& ours = run.column("energy_strain_j");
  ASSERT_EQ(ours.size(), theirs.size() + 1);  // the start is ours alone
  const double largest = *std::max_element(theirs.begin(), theirs.end());
  EXPECT_GT(largest, 5e-3);
  double deviation = 0.0;
  for (std::size_t i = 0; i < theirs.size(); ++i) deviation = std::max(deviation, std::abs(ours[i + 1] - theirs[i]));
  RecordProperty("deviation", fmt::format("{:.5f}", deviation / largest));
  EXPECT_LT(deviation, 0.01 * largest);
}

/// Every third hexahedron of the Gmsh file is inside out; turned round it has other first nodes, hence round-off.
TEST(AbaqusFiles, GiveTheRunOfTheSameGmshMesh) {
  const TemporaryFolder folder;
  (void)folder.write(block_inp(rod), "rod.inp");
  (void)folder.write(block_msh("rod", rod), "rod.msh");
  const auto of_inp = run_text(pressed_rod("inp = \"rod.inp\""), folder, "inp");
  const auto of_gmsh = run_text(pressed_rod("gmsh = \"rod.msh\""), folder, "gmsh");
  const std::vector<double>& energy = of_gmsh.column("energy_strain_j");
  ASSERT_EQ(of_inp.column("energy_strain_j").size(), energy.size());
  for (std::size_t i = 0; i < energy.size(); ++i)
    EXPECT_NEAR(of_inp.column("energy_strain_j")[i], energy[i], 1e-12 * of_gmsh.largest("energy_strain_j"));
}

TEST(AbaqusFiles, MayMeasureInMillimetres) {
  const TemporaryFolder folder;
  (void)folder.write(block_inp(rod), "rod.inp");
  (void)folder.write(block_inp({10.0, 0.0, 100.0, 2, 20}), "rod_mm.INP");
  const auto metres = run_text(pressed_rod("inp = \"rod.inp\""), folder, "metres");
  const auto millimetres = run_text(pressed_rod("inp = \"rod_mm.INP\", length_unit = \"mm\""), folder, "millimetres");
  const double largest = metres.largest("energy_strain_j");
  EXPECT_NEAR(millimetres.largest("energy_strain_j"), largest, 1e-9 * largest);
}

Outcome checked(const std::string& scene, const TemporaryFolder& folder) {
  return run_command({ricochet_binary(), "check", folder.write(scene)}, folder.path().string());
}

TEST(AbaqusFiles, CheckSaysWhichCardsAreLeftOut) {
  const TemporaryFolder folder;
  (void)folder.write(block_inp(rod) + "*STEP\n*STATIC\n*END STEP\n", "rod.inp");
  const Outcome outcome = checked(pressed_rod("inp = \"rod.inp\""), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out,
              HasSubstr("rod.inp is read for its mesh alone; *HEADING, *STEP, *STATIC, *ENDSTEP left out"));
}

TEST(AbaqusFiles, ASetOfNodesIsNoSurface) {
  const TemporaryFolder folder;
  (void)folder.write(block_inp(rod), "rod.inp");
  const Outcome outcome = checked(pressed_rod("inp = \"rod.inp\"", "HELD"), folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, HasSubstr("found surface \"HELD\""));
  EXPECT_THAT(outcome.error, HasSubstr("write *SURFACE, NAME=HELD there"));
}

TEST(AbaqusFiles, AreNamedByTheirOwnKey) {
  const TemporaryFolder folder;
  (void)folder.write(block_inp(rod), "rod.inp");
  EXPECT_THAT(checked(pressed_rod("gmsh = \"rod.inp\""), folder).error, HasSubstr("the key of an .inp file is inp"));
  EXPECT_THAT(checked(pressed_rod("inp = \"rod.msh\""), folder).error, HasSubstr("whose name ends with .inp"));
  EXPECT_THAT(checked(pressed_rod("inp = \"none.inp\""), folder).error, HasSubstr("there is no file"));
  EXPECT_THAT(checked(pressed_rod("inp = \"rod.inp\", gmsh = \"rod.msh\""), folder).error,
              HasSubstr("only with no inp beside it"));
  EXPECT_THAT(checked(pressed_rod("inp = \"rod.inp\", length_m = 1.0"), folder).error,
              HasSubstr("only with a structured mesh"));
}

/// The digest that both sides of a run compare is also of the mesh.
TEST(AbaqusFiles, ArePartOfTheScenesDigest) {
  const TemporaryFolder folder;
  (void)folder.write(block_inp(rod), "rod.inp");
  const auto before = run_text(pressed_rod("inp = \"rod.inp\""), folder, "scene");
  (void)folder.write(block_inp(rod) + "** another\n", "rod.inp");
  const auto after = run_text(pressed_rod("inp = \"rod.inp\""), folder, "scene2");
  EXPECT_NE(before.summary.at("scene_sha256"), after.summary.at("scene_sha256"));
}

}  // namespace
}  // namespace ricochet::test
