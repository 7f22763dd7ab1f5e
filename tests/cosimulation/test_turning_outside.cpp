// Bodies that turn or slide may touch by sides that their contact does not name: what is said of it, and the surface
// "outside" of all sides.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// A brick of 20 mm in flight, which lands on the corner of its sides "inner" and "end".
std::string landing(const std::string& protocol, const std::string& brick_surface, bool on_plane) {
  const std::string table = on_plane ? "" : R"([[body]]
name = "table"
material = "steel_a36"
mesh = { length_m = 0.01, start_m = -0.01, height_m = 0.05, elements = [20, 4], place = { moved_m = [-0.03, 0.0] } }
[[body.support]]
surface = "start"
fixed = ["x", "y"]
)";
  const std::string contact = on_plane ? fmt::format(R"(["brick.{}", "rigid_plane"]
rigid_place_m = [0.0, 0.0]
normal = [0.0, -1.0])",
                                                     brick_surface)
                                       : fmt::format(R"(["table.end", "brick.{}"])", brick_surface);
  return fmt::format(R"(model = "plane_strain"
[[body]]
name = "brick"
large_rotation = true
material = "steel_a36"
initial_velocity_m_s = [1.0, -2.0]
initial_angular_velocity_rad_s = 200.0
mesh = {{ length_m = 0.02, height_m = 0.02, elements = [8, 8], place = {{ turned_deg = 80.0, moved_m = [0.0, 0.002] }} }}
{}[contact]
surfaces = {}
friction_coefficient = 0.3
[partition]
implicit_length_m = {{ brick = 0.002{} }}
[time]
step_s = 1.2e-7
end_s = 2e-3
[coupling]
protocol = "{}"
[output]
history_every = 40
)",
                     table, contact, on_plane ? "" : ", table = 0.003", protocol);
}

/// Height of that corner, half a diagonal from the middle, above plane and table.
double corner_m(double time_s) {
  const double angle = (135.0 + 80.0) * std::numbers::pi / 180.0 + 200.0 * time_s, half = 0.01 * std::sqrt(2.0);
  const double middle_m =
      0.002 + 0.01 * (std::sin(80.0 * std::numbers::pi / 180.0) + std::cos(80.0 * std::numbers::pi / 180.0));
  return middle_m - 2.0 * time_s + half * std::sin(angle);
}

class Landing : public testing::TestWithParam<std::string> {};

TEST_P(Landing, OnASideThatNoContactNamesStopsTheRun) {
  for (const bool on_plane : {false, true}) {
    const TemporaryFolder folder;
    const RunResult run = run_file(folder.write(landing(GetParam(), "start", on_plane)), folder);
    EXPECT_EQ(run.outcome.code, 6) << on_plane << run.outcome.error;
    EXPECT_THAT(run.outcome.error,
                HasSubstr(fmt::format("bodies 'brick' and '{}' overlap by", on_plane ? "rigid_plane" : "table")));
    EXPECT_THAT(run.outcome.error, HasSubstr("beside the surfaces that the contact names"));
    const auto& found = run.summary.at("outside_model").at(0);
    EXPECT_EQ(found.at("kind"), "overlap");
    const double depth_m = -corner_m(found.at("first_s").get<double>());
    EXPECT_GT(depth_m, 0.25 * 2.5e-3 - 2e-6) << "a quarter of an edge";
    EXPECT_LT(depth_m, 0.25 * 2.5e-3 + 5e-5) << "within one look";
    EXPECT_LE(run.summary.at("valid_until_s").get<double>(), found.at("first_s").get<double>());
    EXPECT_EQ(run.largest("contact_force_n"), 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Brick, Landing, testing::Values("hughes_liu", "all_implicit", "all_explicit"),
                         [](const auto& test) { return test.param; });

TEST(LandingOutside, IsFeltAlikeByEveryMethodOnPlaneAndTable) {
  for (const bool on_plane : {false, true}) {
    double impulse_n_s = 0.0;
    for (const std::string protocol : {"all_explicit", "hughes_liu", "all_implicit"}) {
      const TemporaryFolder folder;
      const RunResult run = run_text(landing(protocol, "outside", on_plane), folder);
      const double own_n_s = run.summary.at("contact_impulse_n_s").get<double>();
      if (impulse_n_s == 0.0) impulse_n_s = own_n_s;
      EXPECT_GT(own_n_s, 0.5 * 3.14 * 2.0) << "half of what the brick brings";
      EXPECT_NEAR(own_n_s / impulse_n_s, 1.0, 5e-3) << protocol << on_plane;
      EXPECT_LT(run.summary.at("angular_momentum_error_max").get<double>(), 1e-3);
    }
  }
}

TEST(LandingOutside, IsASurfaceOfBodiesThatTurnAlone) {
  const std::string text = replaced(landing("hughes_liu", "outside", false), "\"table.end\"", "\"table.outside\"");
  EXPECT_THAT(check_refusal(text), HasSubstr("found \"table.outside\""));
}

TEST(LandingOutside, IsWhatIsSaidOfASideThatFacesAway) {
  const std::string text = replaced(landing("hughes_liu", "start", false), "brick.start", "brick.end");
  EXPECT_THAT(check_refusal(text), HasSubstr("or of a body that turns all sides at once, \"outside\""));
}

/// A block slides on a floor by 10 mm to a wall, which is a piece of the floor's body.
TEST(SlidingBlock, ThatMeetsAWallThatNoContactNamesStopsTheRun) {
  const std::string block = "surfaces = [\"block.start\", \"room.floor.end\"]";
  const auto text = [&](const std::string& contacts) {
    return R"(model = "plane_strain"
[[body]]
name = "block"
material = "steel_a36"
mesh = { length_m = 0.01, height_m = 0.01, elements = [4, 4] }
initial_velocity_m_s = [10.0, -0.01]
[[body]]
name = "room"
material = "steel_a36"
[[body.mesh.piece]]
name = "floor"
length_m = 0.01
start_m = -0.01
height_m = 0.05
elements = [20, 4]
[[body.mesh.piece]]
name = "wall"
length_m = 0.02
height_m = 0.01
elements = [4, 8]
[body.mesh.piece.place]
moved_m = [0.02, 0.0]
[[body.mesh.tie]]
surfaces = ["floor.end", "wall.start"]
[[body.support]]
surface = "floor.start"
fixed = ["x", "y"]
)" + contacts +
           R"([partition]
implicit_length_m = { block = 0.0, room = 0.0 }
[time]
step_s = 1e-7
end_s = 1.5e-3
[output]
history_every = 10
)";
  };
  const TemporaryFolder folder;
  const RunResult run = run_file(folder.write(text("[contact]\n" + block + "\n")), folder);
  EXPECT_EQ(run.outcome.code, 6) << run.outcome.error;
  EXPECT_THAT(run.outcome.error, HasSubstr("bodies 'block' and 'room' overlap by 0.000625 m"));
  EXPECT_NEAR(run.summary.at("outside_model").at(0).at("first_s").get<double>(), 1.0625e-3, 2e-6)
      << "10 mm, and a quarter of an edge";
  const TemporaryFolder other;
  const RunResult stopped =
      run_text(text("[[contact]]\nname = \"below\"\n" + block +
                    "\n[[contact]]\nname = \"beside\"\nsurfaces = [\"block.outer\", \"room.wall.inner\"]\n"),
               other);
  EXPECT_GT(stopped.largest("contact_force_n/beside"), 0.0);
}

/// A block that spins lands on a corner, for which surfaces that lie parallel at the start have no row: it comes in
/// when it is 1.5 um deep in the base already, which a window of 60 ns would push out at 24 m/s.
class CornerThatComesIn : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

TEST_P(CornerThatComesIn, MakesNoEnergy) {
  const auto& [protocol, law] = GetParam();
  const TemporaryFolder folder;
  const RunResult run = run_text(fmt::format(R"(model = "plane_strain"
[[body]]
name = "base"
large_rotation = true
material = {{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
mesh = {{ start_m = -0.01, length_m = 0.01, height_m = 0.02, elements = [18, 9], place = {{ moved_m = [-0.01, 0.0] }} }}
[[body]]
name = "block"
large_rotation = true
material = {{ youngs_modulus_pa = 70e9, poisson_ratio = 0.0, density_kg_m3 = 8000.0 }}
initial_velocity_m_s = [0.0, -1.0]
initial_angular_velocity_rad_s = 300.0
mesh = {{ length_m = 0.006, height_m = 0.008, elements = [5, 5], place = {{ moved_m = [-0.003, 1e-5] }} }}
[contact]
surfaces = ["base.end", "block.start"]
multiplier_update = "{}"
[time]
step_s = 6e-8
end_s = 6e-5
[partition]
implicit_length_m = {{ base = 0.003, block = 0.002 }}
[coupling]
protocol = "{}"
)",
                                             law, protocol),
                                 folder);
  EXPECT_GT(run.last("contact_impulse_n_s"), 0.0);
  EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-9);
  EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -0.03) << "what the node that strikes gives up";
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-10);
  EXPECT_LT(run.summary["angular_momentum_error_max"].get<double>(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Protocols, CornerThatComesIn,
                         testing::Values(std::tuple("all_explicit", "trapezoidal_reset"),
                                         std::tuple("all_implicit", "trapezoidal_reset"),
                                         std::tuple("hughes_liu", "trapezoidal_reset"),
                                         std::tuple("all_implicit", "fully_implicit"),
                                         std::tuple("hughes_liu", "fully_implicit")));

/// A side of the one body is seen by a side of the other almost along itself: it lies opposite nothing, else its shape
/// functions there were up to 1e65.
TEST(LandingOutside, HasNoRowsOfFacesThatAreSeenFromTheSide) {
  const TemporaryFolder folder;
  const RunResult run = run_text(R"(model = "solid"
[[body]]
name = "low"
large_rotation = true
material = { youngs_modulus_pa = 20e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }
[body.mesh]
length_m = 0.004
height_m = 0.016
width_m = 0.016
elements = [3, 2, 4]
place = { moved_m = [-0.008, -0.008, 0.0] }
[[body]]
name = "high"
rigid = true
large_rotation = true
material = { youngs_modulus_pa = 70e9, poisson_ratio = 0.0, density_kg_m3 = 8000.0 }
initial_velocity_m_s = [0.0, 0.0, -5.0]
[body.mesh]
length_m = 0.006
height_m = 0.006
width_m = 0.006
elements = [5, 4, 4]
place = { turned_deg = [0.0, 5.0, 0.0], about_m = [0.003, 0.003, 0.0], moved_m = [-0.003, -0.003, 0.0042614672282429746] }
[contact]
surfaces = ["high.outside", "low.outside"]
normal = [0.0, 0.0, -1.0]
friction_coefficient = 0.3
[time]
step_s = 6e-8
end_s = 4e-5
[coupling]
protocol = "all_explicit"
)",
                                 folder);
  EXPECT_GT(run.last("contact_impulse_n_s"), 1e-3);
  EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-6);
  EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-10);
}

/// A tilted block that spins and slides presses by one edge, whose end comes in from beside the other surface when it
/// is 22 um deep, more than a hundredth of an edge. It touches there from then on, and moves no other pair.
TEST(CornerFromBeside, MakesNoEnergy) {
  const TemporaryFolder folder;
  for (const char* protocol : {"all_explicit", "all_implicit"}) {
    const RunResult run = run_text(fmt::format(R"(model = "solid"
[[body]]
name = "low"
large_rotation = true
material = {{ youngs_modulus_pa = 20e9, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }}
[body.mesh]
length_m = 0.004
height_m = 0.006
width_m = 0.006
elements = [3, 2, 2]
refine = [{{ from_m = [0.0, 0.0, 0.0], to_m = [0.0024, 0.0036, 0.002], ratio = 2 }}]
place = {{ moved_m = [-0.003, -0.003, 0.0] }}
[[body.prescribed]]
surface = "start"
turn_rad = [0.0, 200.0, 0.0]
about_m = [0.003, 0.0, -0.002]
amplitude = {{ time_s = [0.0, 1.0], factor = [0.0, 1.0] }}
[[body]]
name = "high"
large_rotation = true
initial_angular_velocity_rad_s = [100.0, 200.0, 50.0]
initial_velocity_m_s = [0.0, 0.0, -5.0]
material = {{ youngs_modulus_pa = 70e9, poisson_ratio = 0.0, density_kg_m3 = 8000.0 }}
[body.mesh]
length_m = 0.006
height_m = 0.006
width_m = 0.006
elements = [3, 2, 4]
place = {{ turned_deg = [0.0, 5.0, 0.0], about_m = [0.003, 0.003, 0.0], moved_m = [-0.003, -0.003, 0.004461467228242974] }}
[contact]
surfaces = ["high.start", "low.end"]
friction_coefficient = 0.3
[time]
step_s = 6e-8
end_s = 8e-5
[coupling]
protocol = "{}"
)",
                                               protocol),
                                   folder, protocol);
    EXPECT_GT(run.last("contact_impulse_n_s"), 0.005) << protocol;
    EXPECT_LT(run.summary["energy_error_highest"].get<double>(), 1e-6) << protocol;
    EXPECT_GT(run.summary["energy_error_lowest"].get<double>(), -0.05) << protocol;
    EXPECT_LT(run.summary["momentum_error_max"].get<double>(), 1e-10) << protocol;
  }
}

class CrossingEdges : public testing::TestWithParam<const char*> {};

/// Two bricks meet edge across edge, in the middle and beside it, on nodes of the edges and between them: when they are
/// there, and with no more energy than they had. Elements half as large change the impulse by 1 %.
TEST_P(CrossingEdges, AreFelt) {
  struct Meeting {
    int cells;
    const char* beside_m;
    double impulse_n_s;
  };
  const auto brick = [](const char* name, int cells, double down_m_s, const std::string& place) {
    return fmt::format(R"([[body]]
name = "{0}"
large_rotation = true
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }}
initial_velocity_m_s = [0.0, 0.0, {3}]
[body.mesh]
length_m = 0.01
height_m = 0.01
width_m = 0.01
elements = [{1}, {1}, {1}]
place = {{ about_m = [0.005, 0.005, 0.005], {2} }}
)",
                       name, cells, place, -down_m_s);
  };
  constexpr double window_s = 5e-7, apart_m = 0.0145 - 0.01 * std::numbers::sqrt2, speed_m_s = 5.0;
  for (const auto& [cells, beside_m, impulse_n_s] :
       {Meeting{4, "0.0, 0.0", 4.98e-3}, Meeting{5, "0.0, 0.0", 4.98e-3}, Meeting{4, "0.002, 0.0007", 4.43e-3}}) {
    SCOPED_TRACE(fmt::format("{} cells, {}", cells, beside_m));
    const std::string scene = "model = \"solid\"\n" + brick("low", cells, 0.0, "turned_deg = [45.0, 0.0, 0.0]") +
                              brick("high", cells, speed_m_s,
                                    fmt::format("turned_deg = [0.0, 45.0, 0.0], moved_m = [{}, 0.0145]", beside_m)) +
                              fmt::format(R"([contact]
surfaces = ["low.outside", "high.outside"]
normal = [0.0, 0.0, 1.0]
[time]
step_s = {}
end_s = 3e-4
[partition]
implicit_length_m = {{ low = 0.0025, high = 0.0025 }}
[coupling]
protocol = "{}"
)",
                                          window_s, GetParam());
    const TemporaryFolder folder;
    const RunResult run = run_text(scene, folder);
    const auto& force = run.column("contact_force_n");
    const auto first = std::find_if(force.begin(), force.end(), [](double f) { return f > 0.0; });
    EXPECT_NEAR(static_cast<double>(first - force.begin()) * window_s, apart_m / speed_m_s, 2.0 * window_s);
    EXPECT_NEAR(run.last("contact_impulse_n_s"), impulse_n_s, 0.01 * impulse_n_s);
    EXPECT_LT(run.summary.at("energy_error_highest").get<double>(), 1e-9);
    EXPECT_GT(run.summary.at("energy_error_lowest").get<double>(), -5e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, CrossingEdges, testing::Values("all_explicit", "all_implicit", "hughes_liu"));

}  // namespace
}  // namespace ricochet::test
