// [body.mesh.place]: a scene that is turned and moved as a whole runs as it did; a brick on its corner.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <string>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

constexpr const char* steel = "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }";

/// A block flies end on onto one that is half as wide, with friction. `place` of both meshes, and what turns
/// directions.
template <class Turn>
std::string two_blocks(bool solid, const std::string& protocol, const std::string& place, const Turn& turn) {
  const auto mesh = [&](double start_m, double height_m, int across) {
    return solid ? fmt::format("start_m = {}, length_m = 0.04, height_m = {}, width_m = 0.02, elements = [{}, 2, 8]",
                               start_m, height_m, across)
                 : fmt::format("start_m = {}, length_m = 0.04, height_m = {}, elements = [{}, 8]", start_m, height_m,
                               across);
  };
  return fmt::format(R"(model = "{}"
[[body]]
name = "low"
material = {}
mesh = {{ {}{} }}
initial_velocity_m_s = {}
[[body]]
name = "high"
material = {}
mesh = {{ {}{} }}
[contact]
surfaces = ["low.end", "high.start"]
friction_coefficient = 0.2
{}[time]
safety_factor = 0.7
end_s = 2e-5
[coupling]
protocol = "{}"
[output]
probes_every = 1
[[output.probe]]
name = "p"
body = "high"
at_m = {}
)",
                     solid ? "solid" : "plane_strain", steel, mesh(0.0, 0.04, 4), place, turn(1.0, 0.0, 9.0, false),
                     steel, mesh(0.04, 0.02, 2), place,
                     protocol == "hughes_liu" ? "[partition]\nimplicit_length_m = { low = 0.01, high = 0.01 }\n" : "",
                     protocol, turn(0.01, 0.01, 0.06, true));
}

struct Turned {
  bool solid;
  const char* protocol;
};

class PlacedMesh : public testing::TestWithParam<Turned> {};

TEST_P(PlacedMesh, RunsAsTheOneThatStandsStraight) {
  const auto& [solid, protocol] = GetParam();
  const TemporaryFolder folder;
  const double degree = std::numbers::pi / 180.0;
  const auto straight = [&](double x, double y, double z, bool) {
    return solid ? fmt::format("[{}, {}, {}]", x, y, z) : fmt::format("[{}, {}]", x, z);
  };
  // A third of a turn about (1, 1, 1) makes x y, y z and z x; 30 degrees in the plane.
  const auto turned = [&](double x, double y, double z, bool place) {
    if (solid && place) return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", z + 1.0, x - 2.0, y + 3.0);
    if (solid) return fmt::format("[{}, {}, {}]", z, x, y);
    const double c = std::cos(30.0 * degree), s = std::sin(30.0 * degree);
    const double about_x = place ? 0.1 : 0.0, about_y = place ? 0.2 : 0.0;
    return fmt::format("[{:.17g}, {:.17g}]", about_x + c * (x - about_x) - s * (z - about_y) + (place ? 1.0 : 0.0),
                       about_y + s * (x - about_x) + c * (z - about_y) + (place ? -2.0 : 0.0));
  };
  const double third = 120.0 / std::sqrt(3.0);
  const std::string place =
      solid ? fmt::format(", place = {{ turned_deg = [{0:.17g}, {0:.17g}, {0:.17g}], moved_m = [1.0, -2.0, 3.0] }}",
                          third)
            : ", place = { turned_deg = 30.0, about_m = [0.1, 0.2], moved_m = [1.0, -2.0] }";
  const RunResult expected = run_text(two_blocks(solid, protocol, "", straight), folder, "straight");
  const RunResult run = run_text(two_blocks(solid, protocol, place, turned), folder, "turned");
  for (const char* name : {"contact_force_n", "friction_force_n", "energy_kinetic_j", "energy_strain_j"}) {
    const auto &a = expected.column(name), &b = run.column(name);
    ASSERT_EQ(a.size(), b.size());
    const double largest = std::max(expected.largest(name), -expected.smallest(name));
    EXPECT_GT(largest, 0.0) << name;
    for (std::size_t n = 0; n < a.size(); ++n)
      ASSERT_NEAR(std::abs(a[n]), std::abs(b[n]), 1e-8 * largest) << name << ", row " << n;
  }
  const auto von_mises = [](const RunResult& of) {
    return read_history(of.folder + "/probes.csv").at("p.von_mises_pa");
  };
  EXPECT_GT(von_mises(expected).back(), 1e6);
  EXPECT_NEAR(von_mises(run).back() / von_mises(expected).back(), 1.0, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Models, PlacedMesh,
                         testing::Values(Turned{false, "all_explicit"}, Turned{false, "hughes_liu"},
                                         Turned{true, "hughes_liu"}),
                         [](const auto& info) {
                           return fmt::format("{}_{}", info.param.solid ? "solid" : "plane", info.param.protocol);
                         });

/// The plane acts on the corner, at the origin: about it the brick keeps the angular momentum of its fall, and a rigid
/// one would take no more than the impulse 2 m v/(1 + m arm^2/I), with its mass m and its moment of inertia I.
TEST(PlacedMesh, FallsOnItsCorner) {
  const TemporaryFolder folder;
  const double angle = 30.0 * std::numbers::pi / 180.0, c = std::cos(angle), s = std::sin(angle);
  const double arm_m = 0.01 * s - 0.005 * c;  // of the corner, from the middle
  const RunResult run = run_text(fmt::format(R"(model = "plane_strain"
[[body]]
name = "brick"
material = {}
mesh = {{ length_m = 0.02, height_m = 0.01, elements = [8, 16], place = {{ turned_deg = 30.0, moved_m = [0.0, 1e-7] }} }}
large_rotation = true
initial_velocity_m_s = [0.0, -1.0]
[contact]
surfaces = ["brick.start", "rigid_plane"]
rigid_place_m = [0.0, 0.0]
normal = [0.0, -1.0]
[time]
safety_factor = 0.8
end_s = 6e-5
[coupling]
protocol = "all_explicit"
)",
                                             steel),
                                 folder);
  const double impulse = run.last("contact_impulse_n_s"), mass_kg = 7850.0 * 0.02 * 0.01;
  const double inertia = mass_kg * (0.02 * 0.02 + 0.01 * 0.01) / 12.0;
  EXPECT_GT(impulse, 0.5 * mass_kg);
  EXPECT_LT(impulse, 2.0 * mass_kg / (1.0 + mass_kg * arm_m * arm_m / inertia));
  EXPECT_NEAR(run.last("velocity_mean_brick_m_s"), -impulse / mass_kg + 1.0, 1e-3);
  EXPECT_LT(std::abs(run.last("momentum_t_kg_m_s")), 1e-13);
  EXPECT_NEAR(run.last("angular_momentum_z_kg_m2_s") / (mass_kg * arm_m), 1.0, 1e-2);
  EXPECT_LT(run.summary.at("angular_momentum_error_max").get<double>(), 1e-4);
}

}  // namespace
}  // namespace ricochet::test
