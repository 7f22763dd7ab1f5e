// Contact is found where bodies are: a flight of any length before it changes nothing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include "tests/support/plane_grid.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

constexpr double radius_m = 0.01, step_s = 5e-8, speed_m_s = 10.0;

struct Discs {
  double apart_m = 0.0, gap_m = 0.0;  ///< of the meshes, and initial_gap_m
  double along_m_s = 0.0;             ///< of each disc across the line of middles
  int lower_cells = 16, upper_cells = 16;
  const char *first = "lower", *second = "upper";

  [[nodiscard]] int windows_of_flight() const {
    return static_cast<int>(std::lround((apart_m + gap_m) / (2.0 * speed_m_s * step_s)));
  }
};

/// Two discs that meet head on, at a velocity that may have a part across.
RunResult collide(const Discs& d, const TemporaryFolder& folder, const std::string& more = "") {
  const double aside = d.along_m_s / speed_m_s * (d.apart_m + d.gap_m);
  (void)folder.write(disc_msh("lower", 0.0, -radius_m, radius_m, d.lower_cells, true), "lower.msh");
  (void)folder.write(disc_msh("upper", aside, radius_m + d.apart_m, radius_m, d.upper_cells, false), "upper.msh");
  std::string text = "model = \"plane_strain\"\n";
  for (const auto& [name, sign] : {std::pair{"lower", 1.0}, std::pair{"upper", -1.0}})
    text += fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 "
        "}}\nmesh = {{ gmsh = \"{}.msh\" }}\ninitial_velocity_m_s = [{}, {}]\n",
        name, name, sign * d.along_m_s, sign * speed_m_s);
  text += fmt::format(
      "[contact]\nsurfaces = [\"{}.cap\", \"{}.cap\"]\ninitial_gap_m = {}\nfriction_coefficient = 0.0\n[time]\n"
      "step_s = {}\nend_s = {:.17g}\n[output]\nhistory_every = 1\n[coupling]\nprotocol = \"all_explicit\"\n",
      d.first, d.second, d.gap_m, step_s, (d.windows_of_flight() + 1100) * step_s);
  return run_text(text + more, folder);
}

/// By the place of the meshes and by initial_gap_m; but for the first windows, in which discs that touch at the start
/// close at once.
TEST(DiscsThatFly, HaveTheForceOfDiscsThatTouchAtTheStart) {
  constexpr std::size_t first_windows = 20;
  const TemporaryFolder touching_folder;
  const RunResult touching = collide({}, touching_folder);
  const auto& expected = touching.column("contact_force_n");
  const double peak = *std::max_element(expected.begin(), expected.end());
  EXPECT_GT(peak, 1e6);
  for (const Discs& flight : {Discs{.apart_m = 0.1 * radius_m}, Discs{.apart_m = 0.5 * radius_m},
                              Discs{.apart_m = 2.0 * radius_m}, Discs{.gap_m = 0.5 * radius_m}}) {
    const TemporaryFolder folder;
    const RunResult run = collide(flight, folder);
    const auto& force = run.column("contact_force_n");
    const auto flown = static_cast<std::size_t>(flight.windows_of_flight());
    ASSERT_GE(force.size(), flown + expected.size() - 1);
    for (std::size_t i = 0; i + 1 < flown; ++i) ASSERT_EQ(force[i], 0.0) << i;
    for (std::size_t i = first_windows; i + 1 < expected.size(); ++i)
      ASSERT_NEAR(force[flown + i], expected[i], 5e-5 * peak) << flight.apart_m << " " << i;
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  }
}

/// Rows are then written anew a hundred times on the way: the force agrees but for what each of them jumps by.
TEST(DiscsThatFly, ObliquelyHaveTheImpulseAndThePeakOfDiscsThatTouchAtTheStart) {
  const TemporaryFolder touching_folder;
  const RunResult touching = collide({.along_m_s = 5.0}, touching_folder);
  for (const Discs& flight :
       {Discs{.apart_m = 0.1 * radius_m, .along_m_s = 5.0}, Discs{.apart_m = 2.0 * radius_m, .along_m_s = 5.0},
        Discs{.gap_m = 0.5 * radius_m, .along_m_s = 5.0}}) {
    const TemporaryFolder folder;
    const RunResult run = collide(flight, folder);
    EXPECT_NEAR(run.last("contact_impulse_n_s") / touching.last("contact_impulse_n_s"), 1.0, 2e-5);
    EXPECT_NEAR(run.largest("contact_force_n") / touching.largest("contact_force_n"), 1.0, 2e-3);
    EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 2.5e-3);
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  }
}

/// Without friction an impact at 20 or 30 degrees changes the energy no more than a straight one.
TEST(DiscsThatFly, ObliquelyKeepTheEnergyAsStraightOnesDo) {
  for (const auto& [cells, most] : {std::pair{16, 2.5e-3}, std::pair{32, 8e-4}}) {
    for (const double along_m_s : {0.0, 3.64, 5.77}) {
      const TemporaryFolder folder;
      const RunResult run = collide({.along_m_s = along_m_s, .lower_cells = cells, .upper_cells = cells}, folder);
      EXPECT_LT(run.summary.at("energy_error_max").get<double>(), most) << cells << " " << along_m_s;
    }
  }
}

/// Also from where rows have been written anew and have an offset.
TEST(DiscsThatFly, GoOnFromACheckpointToTheSameBytes) {
  const TemporaryFolder folder;
  const RunResult whole = collide({.along_m_s = 5.77}, folder, "[checkpoint]\nevery_windows = 550\n");
  (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
}

class TiltedBlock : public testing::TestWithParam<const char*> {};

/// A block that is tilted by 5 degrees falls on a softer one that slides askew below it, so that nodes of that come to
/// lie beyond the block's sides: they touch nothing. Elements half as large change the impulse by 1 %.
TEST_P(TiltedBlock, KeepsItsEnergyWhereNodesLieBeyondIt) {
  const TemporaryFolder folder;
  const RunResult run = run_text(fmt::format(R"(model = "solid"
[[body]]
name = "base"
material = {{ youngs_modulus_pa = 20e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }}
initial_velocity_m_s = [2.0, -0.6666666666666666, 0.0]
[body.mesh]
length_m = 0.006
height_m = 0.006
width_m = 0.006
elements = [8, 7, 4]
place = {{ moved_m = [-0.003, -0.003, 1e-5] }}
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 70e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
initial_velocity_m_s = [0.0, 0.0, -2.0]
[body.mesh]
length_m = 0.004
height_m = 0.006
width_m = 0.006
elements = [5, 4, 4]
[body.mesh.place]
turned_deg = [0.0, 5.0, 0.0]
about_m = [0.003, 0.003, 0.0]
moved_m = [-0.003, -0.003, 0.0063714672282429744]
[contact]
surfaces = ["block.start", "base.end"]
[time]
step_s = 6e-8
end_s = 1e-4
[partition]
implicit_length_m = {{ base = 0.003, block = 0.002 }}
[coupling]
protocol = "{}"
)",
                                             GetParam()),
                                 folder);
  EXPECT_NEAR(run.last("contact_impulse_n_s"), 4.16e-4, 0.04e-4) << "that of elements half as large";
  EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9);
  EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -3e-3);
}

/// The lower edge of a tilted block is 50 um above a flat one, falls with 1 m/s and slides with 10 m/s: that the bodies
/// are no parallel ones changes neither the time of the impact nor, where the edge slides on and lands again, the
/// energy.
TEST_P(TiltedBlock, TouchesByItsEdgeWhereverItSlides) {
  constexpr double window_s = 3e-8;
  for (const bool solid : {false, true}) {
    const TemporaryFolder folder;
    const RunResult run = run_text(
        fmt::format(R"(model = "{}"
[[body]]
name = "base"
material = {{ youngs_modulus_pa = 20e9, poisson_ratio = 0.0, density_kg_m3 = 2700.0 }}
[body.mesh]
length_m = 0.006
height_m = 0.016
{}
place = {{ moved_m = [-0.008{}, 0.0] }}
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 20e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
initial_velocity_m_s = [10.0{}, -1.0]
[body.mesh]
length_m = 0.004
height_m = 0.010
{}
[body.mesh.place]
turned_deg = {}
about_m = [0.0{}, 0.0]
moved_m = [-0.005{}, {:.12g}]
[contact]
surfaces = ["base.end", "block.start"]
[time]
step_s = {}
end_s = 1.5e-4
[partition]
implicit_length_m = {{ base = 0.003, block = 0.002 }}
[coupling]
protocol = "{}"
)",
                    solid ? "solid" : "plane_strain",
                    solid ? "width_m = 0.016\nelements = [3, 2, 2]" : "elements = [3, 2]", solid ? ", -0.008" : "",
                    solid ? ", -3.0" : "", solid ? "width_m = 0.010\nelements = [5, 4, 4]" : "elements = [5, 4]",
                    solid ? "[0.0, -5.0, 0.0]" : "5.0", solid ? ", 0.0" : "", solid ? ", -0.005" : "", 0.006 + 50e-6,
                    window_s, GetParam()),
        folder);
    const auto& force = run.column("contact_force_n");
    const auto first = std::find_if(force.begin(), force.end(), [](double f) { return f > 0.0; });
    EXPECT_NEAR(static_cast<double>(first - force.begin()) * window_s, 50e-6, 2.0 * window_s) << solid;
    EXPECT_GT(run.last("contact_impulse_n_s"), 0.0);
    EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9) << solid;
    EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -3e-3) << solid;
  }
}

/// A rigid block that may turn is smaller than the faces of the plate that it falls on, between their nodes: it lands
/// on its own.
TEST_P(TiltedBlock, LandsBetweenTheNodesOfACoarsePlate) {
  const TemporaryFolder folder;
  const RunResult run = run_text(fmt::format(R"(model = "solid"
[[body]]
name = "plate"
material = {{ youngs_modulus_pa = 70e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
[body.mesh]
length_m = 0.006
height_m = 0.016
width_m = 0.016
elements = [3, 3, 3]
place = {{ moved_m = [-0.008, -0.008, 0.0] }}
[[body.support]]
surface = "start"
fixed = ["x", "y", "z"]
[[body]]
name = "block"
rigid = true
large_rotation = true
material = {{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }}
initial_velocity_m_s = [0.0, 0.0, -1.0]
[body.mesh]
length_m = 0.004
height_m = 0.004
width_m = 0.004
elements = [4, 4, 4]
place = {{ moved_m = [-0.002, -0.002, 0.00601] }}
[contact]
surfaces = ["plate.end", "block.start"]
[time]
step_s = 6e-8
end_s = 6e-5
[partition]
implicit_length_m = {{ plate = 0.003 }}
[coupling]
protocol = "{}"
)",
                                             GetParam()),
                                 folder);
  constexpr double momentum_kg_m_s = 8000.0 * 64e-9;
  EXPECT_GT(run.last("contact_impulse_n_s"), momentum_kg_m_s) << "it comes back";
  EXPECT_LT(run.last("contact_impulse_n_s"), 2.0 * momentum_kg_m_s);
  const auto& gap = run.column("gap_min_m");
  EXPECT_GT(*std::min_element(gap.begin(), gap.end()), -1e-12);
}

/// Where two corners meet a node has a row of its own and one of the other's corner: what the watch on slip divides by
/// is an edge, not their distance.
TEST_P(TiltedBlock, LandsOnABlockAsWideAsItself) {
  const TemporaryFolder folder;
  const RunResult run = run_text(fmt::format(R"(model = "plane_strain"
[[body]]
name = "low"
material = {{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }}
mesh = {{ length_m = 0.004, height_m = 0.01, elements = [8, 4], place = {{ moved_m = [-0.005, 0.0] }} }}
[[body.support]]
surface = "start"
fixed = ["x", "y"]
[[body]]
name = "high"
rigid = true
material = {{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }}
mesh = {{ length_m = 0.004, height_m = 0.006, elements = [8, 2], place = {{ moved_m = [-0.003, 0.004] }} }}
[[body]]
name = "highest"
material = {{ youngs_modulus_pa = 20e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
initial_velocity_m_s = [0.0, -5.0]
[body.mesh]
length_m = 0.006
height_m = 0.006
elements = [3, 2]
place = {{ turned_deg = 0.5, about_m = [0.003, 0.0], moved_m = [-0.003, 0.008028179606495123] }}
[[contact]]
name = "low"
surfaces = ["low.end", "high.start"]
[[contact]]
name = "high"
surfaces = ["highest.start", "high.end"]
[partition]
implicit_length_m = {{ low = 0.002, highest = 0.003 }}
[time]
step_s = 6e-8
end_s = 5e-5
[coupling]
protocol = "{}"
)",
                                             GetParam()),
                                 folder);
  EXPECT_GT(run.last("contact_impulse_n_s/high"), 0.0);
  EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Protocols, TiltedBlock, testing::Values("all_explicit", "all_implicit", "hughes_liu"));

/// In the flight after a slide that has left a pair without a partner, twice: each process begins with the pairs of the
/// start.
TEST(PlatesThatSlideAndFly, GoOnFromACheckpointToTheSameBytes) {
  const TemporaryFolder folder;
  std::string text = "model = \"plane_strain\"\n";
  for (const auto* body : {"lower", "upper"})
    text += fmt::format(
                "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 4e9, poisson_ratio = 0.25, density_kg_m3 = "
                "1000.0 "
                "}}\n",
                body) +
            (body == std::string("lower")
                 ? "mesh = { start_m = -0.02, length_m = 0.02, height_m = 0.02, elements = [8, 16] }\n"
                   "initial_velocity_m_s = [150.0, 5.0]\n"
                 : "mesh = { length_m = 0.02, height_m = 0.02, elements = [12, 8] }\n");
  text +=
      "[partition]\nimplicit_length_m = { lower = 0.005, upper = 0.005 }\n[contact]\n"
      "surfaces = [\"lower.end\", \"upper.start\"]\nfriction_coefficient = 0.01\n[time]\nstep_s = 2e-7\n"
      "end_s = 4e-5\n[output]\nhistory_every = 1\n[checkpoint]\nevery_windows = 150\n";
  const RunResult whole = run_text(text, folder);
  ASSERT_EQ(whole.column("pairs_open").front(), 13.0);
  ASSERT_EQ(whole.column("pairs_open").back(), 10.0) << "of 13, in flight, too";
  const std::string half = (folder.path() / "half").string();
  std::filesystem::copy(whole.folder, half, std::filesystem::copy_options::recursive);
  const auto windows = checkpoints_in(half);
  ASSERT_EQ(windows.size(), 2U);
  std::filesystem::remove(fmt::format("{}/checkpoint/{}.json", half, windows.back()));
  for (const char* until : {"3.6e-5", "4e-5"}) {
    const auto outcome = resume(half, folder, {"--until", until});
    ASSERT_EQ(outcome.code, 0) << outcome.error;
  }
  EXPECT_EQ(file_text(half + "/history.csv"), file_text(whole.folder + "/history.csv"));
  const std::string last = fmt::format("/checkpoint/{}.implicit.state", windows.back());
  EXPECT_EQ(file_text(half + last), file_text(whole.folder + last));
}

}  // namespace
}  // namespace ricochet::test
