// Bodies that slide along each other by many elements, and off the end.
#include <fmt/format.h>

#include <cmath>

#include "tests/support/run.hpp"
#include "tests/support/vtu.hpp"

namespace ricochet::test {
namespace {

struct Sliding {
  std::string protocol = "hughes_liu";
  double friction = 0.0, gravity_m_s2 = 0.0, end_s = 0.0;
  double velocity_x_m_s = 0.0, velocity_y_m_s = 0.0;
  bool base_is_held = true;
  std::string multiplier_update = "trapezoidal_reset";
};

/// A block, 4 mm by 2 mm, whose left end lies 2 mm from that of a base, 12 mm by 2 mm; elements of 0.5 mm below and
/// 0.4 mm above: no node lies opposite another for long. c_L = 1095 m/s.
std::string block_on_base(const Sliding& s) {
  std::string text = fmt::format(R"(model = "plane_strain"
[[body]]
name = "base"
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }}
mesh = {{ gmsh = "base.msh" }}
{}
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }}
mesh = {{ gmsh = "block.msh" }}
initial_velocity_m_s = [{}, {}]
gravity_m_s2 = [0.0, {}]
[contact]
surfaces = ["block.start", "base.end"]
friction_coefficient = {}
multiplier_update = "{}"
[partition]
implicit_length_m = {{ base = 1.1e-3, block = 0.9e-3 }}
[time]
safety_factor = 0.8
end_s = {}
[output]
history_every = 4
[coupling]
protocol = "{}"
energy_growth_limit = 1.0
)",
                                 s.base_is_held ? "[[body.support]]\nsurface = \"start\"\nfixed = [\"x\", \"y\"]" : "",
                                 s.velocity_x_m_s, s.velocity_y_m_s, -s.gravity_m_s2, s.friction, s.multiplier_update,
                                 s.end_s, s.protocol);
  return text;
}

/// MSH 4.1 text of a rectangle of quadrilaterals with the surfaces "start" (below) and "end".
std::string rectangle_of(const std::string& body, double x, double y, double width, double height, int across, int up) {
  const int row = across + 1, nodes = row * (up + 1);
  std::string text = fmt::format(
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"start\"\n1 2 \"end\"\n2 3 \"{}\"\n"
      "$EndPhysicalNames\n$Entities\n0 2 1 0\n1 0 0 0 1 1 1 1 1 0\n2 0 0 0 1 1 1 1 2 0\n1 0 0 0 1 1 1 1 3 0\n"
      "$EndEntities\n$Nodes\n1 {} 1 {}\n2 1 0 {}\n",
      body, nodes, nodes, nodes);
  for (int n = 1; n <= nodes; ++n) text += fmt::format("{}\n", n);
  for (int n = 0; n < nodes; ++n)
    text += fmt::format("{:.17g} {:.17g} 0\n", x + width * (n % row) / across, y + height * (n / row) / up);
  const int elements = 2 * across + across * up;
  text += fmt::format("$EndNodes\n$Elements\n3 {} 1 {}\n1 1 1 {}\n", elements, elements, across);
  int tag = 0;
  for (int i = 1; i <= across; ++i) text += fmt::format("{} {} {}\n", ++tag, i, i + 1);
  text += fmt::format("1 2 1 {}\n", across);
  for (int i = nodes - across; i < nodes; ++i) text += fmt::format("{} {} {}\n", ++tag, i + 1, i);
  text += fmt::format("2 1 3 {}\n", across * up);
  for (int e = 0; e < across * up; ++e) {
    const int n = 1 + e / across * row + e % across;
    text += fmt::format("{} {} {} {} {}\n", ++tag, n, n + 1, n + row + 1, n + row);
  }
  return text + "$EndElements\n";
}

RunResult run_sliding(const Sliding& s, const TemporaryFolder& folder, int fields_every = 0) {
  (void)folder.write(rectangle_of("base", 0.0, 0.0, 12e-3, 2e-3, 24, 4), "base.msh");
  (void)folder.write(rectangle_of("block", 2e-3, 2e-3, 4e-3, 2e-3, 10, 5), "block.msh");
  std::string text = block_on_base(s);
  if (fields_every > 0) text = with_key(text, "output", "fields_every", std::to_string(fields_every));
  return run_text(with_protocol_of_two_steps(text, s.protocol), folder);
}

constexpr double block_mass_kg = 1000.0 * 4e-3 * 2e-3;

class BlockSlides : public testing::TestWithParam<const char*> {};

/// Coulomb friction brakes a block by mu g: it stops after v0^2/(2 mu g) = 1.5 mm, four elements, and stays.
TEST_P(BlockSlides, ToAStopAfterTheSquareOfItsVelocityOverTwiceMuG) {
  const double v = 3.0, mu = 0.3, g = 1e4, stops_s = v / (mu * g);
  const TemporaryFolder folder;
  const RunResult r = run_sliding(
      {.protocol = GetParam(), .friction = mu, .gravity_m_s2 = g, .end_s = 1.4e-3, .velocity_x_m_s = v}, folder);
  const auto &time = r.column("time_s"), &friction = r.column("friction_impulse_n_s");
  double place = 0.0, velocity = v;  // of the block's middle, from the impulses of friction
  for (std::size_t i = 1; i < time.size(); ++i) {
    const double before = velocity;
    velocity = v - std::abs(friction[i]) / block_mass_kg;
    place += 0.5 * (before + velocity) * (time[i] - time[i - 1]);
    if (time[i] < 0.9 * stops_s) {
      EXPECT_NEAR(velocity, v - mu * g * time[i], 0.02 * v) << time[i];
    }
  }
  EXPECT_NEAR(place, v * v / (2.0 * mu * g), 0.01 * 1.5e-3);
  EXPECT_NEAR(velocity, 0.0, 0.01 * v);
  const double energy = 0.5 * block_mass_kg * v * v;
  EXPECT_NEAR(r.last("energy_friction_j"), energy, 0.025 * energy);
  EXPECT_NEAR(r.last("energy_friction_j") - r.last("energy_contact_j"), energy, 2e-3 * energy)
      << "nodes that lift off and land cost the rest";
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
}

/// Without friction it goes on as it was.
TEST_P(BlockSlides, OnWithoutFriction) {
  const TemporaryFolder folder;
  const RunResult r =
      run_sliding({.protocol = GetParam(), .gravity_m_s2 = 1e4, .end_s = 1e-3, .velocity_x_m_s = 3.0}, folder);
  EXPECT_EQ(r.last("friction_impulse_n_s"), 0.0);
  EXPECT_NEAR(r.last("contact_impulse_n_s"), block_mass_kg * 1e4 * 1e-3, 0.03 * block_mass_kg * 1e4 * 1e-3);
  EXPECT_LT(r.summary.at("energy_error_max").get<double>(), 2e-3);
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
}

/// It flies over the end of the base, 6 mm ahead, at 200 m/s while it is pressed down: no force once it is past, and
/// none that grows at the end.
TEST_P(BlockSlides, OffTheEndAndIsFree) {
  const TemporaryFolder folder;
  const RunResult r =
      run_sliding({.protocol = GetParam(), .gravity_m_s2 = 1e6, .end_s = 70e-6, .velocity_x_m_s = 200.0}, folder);
  const auto &time = r.column("time_s"), &force = r.column("contact_force_n");
  const double weight = block_mass_kg * 1e6;
  double before = 0.0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] > 51e-6) {
      EXPECT_EQ(force[i], 0.0) << time[i] << ": 10 mm from its first place nothing lies below it";
    } else {
      before = std::max(before, force[i]);
    }
  }
  EXPECT_GT(before, 0.5 * weight);
  EXPECT_LT(before, 4.0 * weight);
}

INSTANTIATE_TEST_SUITE_P(Protocols, BlockSlides,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// sum m (x + d) x v over both bodies from a field that one participant wrote, d the mean displacement of a body.
double angular_momentum(const RunResult& run, const std::string& participant, int window) {
  struct Body {
    double x, y, width, height;
    int across, up;
  };
  const auto file = field_files(run.folder, participant, window);
  const auto u = vtu_array(file, "displacement"), v = vtu_array(file, "velocity");
  double sum = 0.0;
  std::size_t first = 0;  // of the body's nodes
  for (const Body& b : {Body{0.0, 0.0, 12e-3, 2e-3, 24, 4}, Body{2e-3, 2e-3, 4e-3, 2e-3, 10, 5}}) {
    const int row = b.across + 1, nodes = row * (b.up + 1);
    const auto mass = [&](int n) {
      const int i = n % row, j = n / row;
      return 1000.0 * b.width * b.height / (b.across * b.up) * (i == 0 || i == b.across ? 0.5 : 1.0) *
             (j == 0 || j == b.up ? 0.5 : 1.0);
    };
    double whole = 0.0, dx = 0.0, dy = 0.0;
    for (int n = 0; n < nodes; ++n) {
      const std::size_t k = 3 * (first + static_cast<std::size_t>(n));
      whole += mass(n);
      dx += mass(n) * u[k];
      dy += mass(n) * u[k + 1];
    }
    for (int n = 0; n < nodes; ++n) {
      const std::size_t k = 3 * (first + static_cast<std::size_t>(n));
      const double x = b.x + b.width * (n % row) / b.across + dx / whole,
                   y = b.y + b.height * (n / row) / b.up + dy / whole;
      sum += mass(n) * (x * v[k + 1] - y * v[k]);
    }
    first += static_cast<std::size_t>(nodes);
  }
  return sum;
}

/// The block hits the free base obliquely and slides four elements while they press each other, without friction. The
/// reset of a velocity at the end of a window has the lever of the window's middle: exact to a half window's slide.
TEST(Slides, KeepingAngularMomentum) {
  struct Case {
    const char *protocol, *participant, *law;
    double tolerance;
  };
  for (const auto& [protocol, participant, law, tolerance] :
       {Case{"all_explicit", "explicit", "trapezoidal_reset", 1e-10},
        Case{"all_implicit", "implicit", "fully_implicit", 1e-10},
        Case{"all_implicit", "implicit", "trapezoidal_reset", 2e-4}}) {
    const TemporaryFolder folder;
    const RunResult r = run_sliding({.protocol = protocol,
                                     .end_s = 20e-6,
                                     .velocity_x_m_s = 300.0,
                                     .velocity_y_m_s = -5.0,
                                     .base_is_held = false,
                                     .multiplier_update = law},
                                    folder, 8);
    EXPECT_GT(r.last("contact_impulse_n_s"), block_mass_kg * 5.0) << protocol;
    const double lever = 6e-3 * block_mass_kg * 300.0;
    const double start = angular_momentum(r, participant, 0);
    for (const int window : {8, 16, 24, 32, 40})
      EXPECT_NEAR(angular_momentum(r, participant, window), start, tolerance * lever) << protocol << law << window;
    EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10) << protocol;
    EXPECT_LT(r.summary.at("angular_momentum_error_max").get<double>(), 2e-4) << protocol << ": strains are";
  }
}

}  // namespace
}  // namespace ricochet::test
