#include <gmock/gmock.h>

#include <numbers>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

// A pressure acts against the outward normal of a surface, and a Gmsh file may measure in another unit than metres.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// A free round bar beside which a plane stands that it never meets.
std::string free_cylinder(const std::string& load) {
  return R"(model = "axisymmetric"
[[body]]
name = "rod"
material = "aluminium_6061_t6"
mesh = { start_m = -0.04, length_m = 0.04, radius_m = 0.01, elements = [4, 16] }
)" + load +
         R"(
[contact]
surfaces = ["rod.end", "rigid_plane"]
initial_gap_m = 0.01
[partition]
implicit_length_m = { rod = 0.01 }
[time]
step_s = 2e-7
end_s = 4e-5
)";
}

TEST(Pressure, PushesAsTheTractionAgainstTheOutwardNormalDoes) {
  const TemporaryFolder folder;
  const auto of_pressure =
      run_text(free_cylinder("traction = [{ surface = \"start\", pressure_pa = 2e5 }]"), folder, "pressure");
  const auto of_traction =
      run_text(free_cylinder("traction = [{ surface = \"start\", traction_pa = [0.0, 2e5] }]"), folder, "traction");
  const double area_m2 = std::numbers::pi * 1e-4;
  EXPECT_NEAR(of_pressure.history.at("momentum_n_kg_m_s").back(), 2e5 * area_m2 * 4e-5, 1e-9 * 2e5 * area_m2 * 4e-5);
  EXPECT_EQ(of_pressure.history, of_traction.history);
}

/// From all sides: the body stays where it is and gets smaller.
TEST(Pressure, FromAllSidesMovesNoCentre) {
  const TemporaryFolder folder;
  const auto run =
      run_text(free_cylinder("traction = [{ surface = \"start\", pressure_pa = 2e5 }, { surface = \"end\", "
                             "pressure_pa = 2e5 }, { surface = \"outer\", pressure_pa = 2e5 }]"),
               folder, "all");
  const double one_end = 2e5 * std::numbers::pi * 1e-4 * 4e-5;
  EXPECT_NEAR(run.history.at("momentum_n_kg_m_s").back(), 0.0, 1e-9 * one_end);
  EXPECT_GT(run.history.at("energy_strain_j").back(), 0.0);
}

/// The faces of a cylinder that lie on its circle push inwards, each along its own normal: together they push nowhere.
TEST(Pressure, AroundASolidCylinderPushesNowhere) {
  const TemporaryFolder folder;
  const auto run = run_text(R"(model = "solid"
[[body]]
name = "rod"
material = "steel_a36"
mesh = { start_m = -0.04, length_m = 0.04, radius_m = 0.01, elements = [4, 8] }
traction = [{ surface = "outer", pressure_pa = 2e5 }]
[contact]
surfaces = ["rod.end", "rigid_plane"]
initial_gap_m = 0.01
[time]
end_s = 1e-5
[coupling]
protocol = "all_explicit"
)",
                            folder, "solid");
  const double whole = 2e5 * 2.0 * std::numbers::pi * 0.01 * 0.04 * 1e-5;
  for (const char* axis : {"n", "t", "b"})
    EXPECT_NEAR(run.history.at(std::string("momentum_") + axis + "_kg_m_s").back(), 0.0, 1e-9 * whole) << axis;
  EXPECT_GT(run.history.at("energy_strain_j").back(), 0.0);
}

TEST(LengthUnit, OfAGmshFileGivesTheRunOfTheSameMeshInMetres) {
  const TemporaryFolder folder;
  const std::string scene = config_text("striker_gmsh"), mesh = file_text(source_folder() + "/configs/striker.msh");
  std::istringstream metres(mesh);
  std::ostringstream inches;
  bool nodes = false;
  inches.precision(17);
  for (std::string line; std::getline(metres, line);) {
    if (line == "$Nodes" || line == "$EndNodes") nodes = line == "$Nodes";
    std::istringstream words(line);
    double x = 0.0, y = 0.0, z = 0.0;
    const bool place = nodes && line.find('.') != std::string::npos && words >> x >> y >> z;
    place ? inches << x / 0.0254 << ' ' << y / 0.0254 << ' ' << z / 0.0254 << '\n' : inches << line << '\n';
  }
  (void)folder.write(inches.str(), "striker.msh");
  std::string text = with_key(scene, "time", "end_s", "5e-6");
  const auto reference = run_text(with_absolute_meshes(text), folder, "metres");
  for (std::size_t at = 0; (at = text.find("gmsh = \"striker.msh\"", at)) != std::string::npos; at += 10)
    text.replace(at, 20, "gmsh = \"striker.msh\", length_unit = \"in\"");
  const auto run = run_text(text, folder, "inches");
  const double force = run.largest("contact_force_n");
  EXPECT_GT(force, 0.0);
  EXPECT_NEAR(force, reference.largest("contact_force_n"), 1e-9 * force);
}

}  // namespace
}  // namespace ricochet::test
