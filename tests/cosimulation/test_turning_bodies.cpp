// large_rotation: free bodies that spin and flip, impacts of what spins, corners and edges, restarts.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <valarray>
#include <vector>

#include "tests/support/plane_grid.hpp"
#include "tests/support/process_table.hpp"
#include "tests/support/same_results.hpp"
#include "tests/support/vtu.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* steel = "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }";

/// Windows of an implicit contact end with closed gaps. Small steps take what the turn of a window changes from the
/// forces of the one before.
void expect_no_overlap(const RunResult& run, const std::string& protocol) {
  const auto gaps = run.column("gap_min_m");
  EXPECT_GT(*std::min_element(gaps.begin(), gaps.end()), protocol == "local_explicit" ? -1e-9 : -1e-15) << protocol;
}

double at_most(const RunResult& run, const char* error) { return run.summary.at(error).get<double>(); }

std::string plate(double spin_rad_s, const std::string& more = "") {
  return fmt::format(R"(model = "plane_strain"
[[body]]
name = "plate"
material = {}
mesh = {{ length_m = 0.06, height_m = 0.02, elements = [4, 12] }}
large_rotation = true
initial_angular_velocity_rad_s = {}
initial_velocity_m_s = [10.0, 3.0]
initial_displacement_m = {{ start = [0.0, 0.0], end = [0.0, 1e-6] }}
[time]
safety_factor = 0.7
end_s = 8e-3
[coupling]
protocol = "all_explicit"
[output]
history_every = 40
probes_every = 40
[[output.probe]]
name = "corner"
body = "plate"
at_m = [0.02, 0.06]
[[output.probe]]
name = "middle"
body = "plate"
at_m = [0.01, 0.03]
{})",
                     steel, spin_rad_s, more);
}

/// Nearly four turns. The middle bears the centrifugal stress rho w^2 L^2/8 along the plate, wherever that points.
TEST(SpinningPlate, TurnsAtItsSpeedAndKeepsItsMomentaAndItsEnergy) {
  const TemporaryFolder folder;
  constexpr double spin = 3000.0;
  const RunResult run = run_text(plate(spin), folder);
  EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-13);
  EXPECT_LT(at_most(run, "momentum_error_max"), 1e-13);
  EXPECT_LT(at_most(run, "energy_error_max"), 1e-5);
  const History probes = read_history(run.folder + "/probes.csv");
  const auto& time_s = probes.at("time_s");
  double along_pa = 0.0, across_pa = 0.0, rows = 0.0, most_off = 0.0;
  for (std::size_t n = 0; n < time_s.size(); ++n) {
    const auto at = [&](const char* name) { return probes.at(name)[n]; };
    const double angle = spin * time_s[n], c = std::cos(angle), s = std::sin(angle);
    const double x = 0.01 + at("corner.displacement_x_m") - at("middle.displacement_x_m"),
                 y = 0.03 + at("corner.displacement_y_m") - at("middle.displacement_y_m");
    most_off = std::max(most_off, std::hypot(x - (c * 0.01 - s * 0.03), y - (s * 0.01 + c * 0.03)) / 0.03);
    const double xx = at("middle.stress_xx_pa"), yy = at("middle.stress_yy_pa"), xy = at("middle.stress_xy_pa");
    along_pa += s * s * xx - 2.0 * s * c * xy + c * c * yy;
    across_pa += c * c * xx + 2.0 * s * c * xy + s * s * yy;
    rows += 1.0;
  }
  EXPECT_LT(most_off, 6e-3) << "it stretches by up to 2e-4, and turns by that less of 24 radians";
  const double expected = 7850.0 * spin * spin * 0.06 * 0.06 / 8.0;
  EXPECT_NEAR(along_pa / rows / expected, 1.0, 0.1);
  EXPECT_LT(std::abs(across_pa / rows), 0.15 * expected);
}

/// Drawn fifty times as large, a turn of a sixth of a degree would be a plate twice its size.
TEST(SpinningPlate, IsDrawnToScale) {
  const TemporaryFolder folder;
  const RunResult run = run_text(
      replaced(replaced(plate(3.0), "initial_velocity_m_s = [10.0, 3.0]\n", ""), "end_s = 8e-3", "end_s = 1e-3"),
      folder);
  EXPECT_THAT(file_text(run.folder + "/report.html"), HasSubstr("Displacements are drawn to scale."));
}

/// Without the frame a plate grows as it turns, and the run says so and what to type.
TEST(SpinningPlate, WithoutAFrameIsStoppedAndToldOfIt) {
  const TemporaryFolder folder;
  const std::string text =
      replaced(replaced(replaced(plate(0.0), "large_rotation = true\ninitial_angular_velocity_rad_s = 0\n", ""),
                        "initial_velocity_m_s = [10.0, 3.0]\n", ""),
               "[time]", "[[body.traction]]\nsurface = \"end\"\ntraction_pa = [1e7, 0.0]\n[time]");
  const RunResult run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 6);
  EXPECT_THAT(run.outcome.error, HasSubstr("a body that turns as a whole takes large_rotation = true"));
}

using Vector = std::valarray<double>;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Three numbers of the spin in the body, then where its axes x, y and z point.
using Turned = Vector;

/// Euler's equations of a rigid body, by the classical Runge-Kutta method: I dw/dt = -w x I w, and the axis R e of the
/// body moves by R (w x e).
Turned euler_step(const Vector& inertia, const Turned& from, double dt) {
  const auto rate = [&](const Turned& x) {
    const Vector w = x[std::slice(0, 3, 1)];
    Turned slope(12);
    slope[std::slice(0, 3, 1)] = Vector(-cross(w, inertia * w) / inertia);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vector e(3);
      e[axis] = 1.0;
      const Vector moves = cross(w, e);
      Vector moved(3);
      for (std::size_t k = 0; k < 3; ++k) moved += moves[k] * Vector(x[std::slice(3 + 3 * k, 3, 1)]);
      slope[std::slice(3 + 3 * axis, 3, 1)] = moved;
    }
    return slope;
  };
  const Turned a = rate(from), b = rate(from + 0.5 * dt * a), c = rate(from + 0.5 * dt * b), d = rate(from + dt * c);
  return from + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d);
}

/// Lumped masses of a stretch in elements have this mean square of their place about the middle [m^2].
double mean_square(double length_m, int elements) {
  return length_m * length_m / 12.0 * (1.0 + 2.0 / (static_cast<double>(elements) * elements));
}

/// A brick that spins about its middle axis flips over (Dzhanibekov), when and how Euler's equations say.
TEST(FreeBrick, FlipsOverAsARigidOne) {
  const TemporaryFolder folder;
  const RunResult run = run_text(fmt::format(R"(model = "solid"
[[body]]
name = "brick"
material = {}
mesh = {{ height_m = 0.03, width_m = 0.02, length_m = 0.01, elements = [6, 4, 2] }}
large_rotation = true
initial_angular_velocity_rad_s = [1.0, 1000.0, 1.0]
[time]
safety_factor = 0.9
end_s = 0.03
[coupling]
protocol = "all_explicit"
[output]
history_every = 200
probes_every = 200
[[output.probe]]
name = "x"
body = "brick"
at_m = [0.03, 0.01, 0.005]
[[output.probe]]
name = "y"
body = "brick"
at_m = [0.015, 0.02, 0.005]
[[output.probe]]
name = "middle"
body = "brick"
at_m = [0.015, 0.01, 0.005]
)",
                                             steel),
                                 folder);
  EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-13);
  EXPECT_LT(at_most(run, "energy_error_max"), 2e-6);
  const double x = mean_square(0.03, 6), y = mean_square(0.02, 4), z = mean_square(0.01, 2);
  const Vector inertia{y + z, x + z, x + y};
  Turned rigid{1.0, 1000.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  const History probes = read_history(run.folder + "/probes.csv");
  const auto& time_s = probes.at("time_s");
  double lowest = 1.0;
  for (std::size_t n = 1; n < time_s.size(); ++n) {
    constexpr int steps = 100;
    for (int k = 0; k < steps; ++k) rigid = euler_step(inertia, rigid, (time_s[n] - time_s[n - 1]) / steps);
    const auto axis = [&](const std::string& probe, std::size_t along, double arm_m) {
      Vector points(3);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::string name = fmt::format(".displacement_{}_m", "xyz"[c]);
        points[c] = (probes.at(probe + name)[n] - probes.at("middle" + name)[n]) / arm_m;
      }
      points[along] += 1.0;
      return points;
    };
    const auto far = [](const Vector& a) { return std::sqrt((a * a).sum()); };
    const Vector along_x = axis("x", 0, 0.015), along_y = axis("y", 1, 0.01);
    ASSERT_LT(far(along_x - Vector(rigid[std::slice(3, 3, 1)])), 1e-3) << time_s[n];
    ASSERT_LT(far(along_y - Vector(rigid[std::slice(6, 3, 1)])), 1e-3) << time_s[n];
    lowest = std::min(lowest, along_y[1]);
  }
  EXPECT_LT(lowest, -0.98) << "it flipped";
}

/// A disc of radius 10 mm and thickness 1 m over a rigid plane.
std::string spinning_disc(double spin_rad_s, double friction, const std::string& protocol = "all_explicit") {
  return fmt::format(R"(model = "plane_strain"
[[body]]
name = "disc"
material = {}
mesh = {{ gmsh = "disc.msh" }}
large_rotation = true
initial_angular_velocity_rad_s = {}
initial_velocity_m_s = [0.0, -5.0]
[contact]
surfaces = ["disc.rim", "rigid_plane"]
rigid_place_m = [0.0, 0.0]
normal = [0.0, -1.0]
friction_coefficient = {}
[time]
safety_factor = 0.8
end_s = 4e-5
[coupling]
protocol = "{}"
)",
                     steel, spin_rad_s, friction, protocol);
}

/// It slips throughout: friction is mu times the pressing impulse, and what it takes off the spin, its moment about the
/// place of contact says.
TEST(SpinningDisc, ThatLandsSlipsAndTakesItsMomentumFromItsSpin) {
  const TemporaryFolder folder;
  (void)folder.write(whole_disc_msh("disc", 0.0, 0.01 + 1e-6, 0.01, 16), "disc.msh");
  for (const char* protocol : {"all_explicit", "all_implicit"}) {
    const RunResult run = run_text(spinning_disc(2000.0, 0.2, protocol), folder, protocol);
    const double pressed = run.last("contact_impulse_n_s"), rubbed = run.last("friction_impulse_n_s");
    EXPECT_NEAR(rubbed / pressed, 0.2, 1e-9) << protocol;
    EXPECT_NEAR(std::abs(run.last("momentum_t_kg_m_s") - run.column("momentum_t_kg_m_s").front()) / rubbed, 1.0, 1e-9);
    EXPECT_LT(at_most(run, "angular_momentum_error_max"), 2e-6) << protocol;
    // About the place that touches friction has no moment: the little that changes is the width of the contact.
    const auto& l = run.column("angular_momentum_z_kg_m2_s");
    EXPECT_LT(std::abs(l.back() - l.front()), 0.1 * rubbed * 0.01);
    EXPECT_GT(rubbed, 4.0);
    EXPECT_LT(at_most(run, "energy_error_max"), 1e-3) << protocol;
  }
}

/// A disc that is let go on a plane inclined by 30 degrees, in a field of 1e5 m/s^2, rolling at 20 m/s or at rest.
std::string disc_on_an_incline(double friction, double speed_m_s, const std::string& protocol) {
  constexpr double field_m_s2 = 1e5;
  std::string text = spinning_disc(-speed_m_s / 0.01, friction, protocol);
  text = replaced(
      text, "[0.0, -5.0]",
      fmt::format("[{}, 0.0]\ngravity_m_s2 = [{}, {}]", speed_m_s, 0.5 * field_m_s2, -std::sqrt(0.75) * field_m_s2));
  if (protocol == "all_implicit") text = replaced(text, "safety_factor = 0.8", "step_s = 1e-7");
  return replaced(text, "end_s = 4e-5", "end_s = 1e-3") +
         "[output]\nprobes_every_s = 2e-5\n[[output.probe]]\nname = \"middle\"\nbody = \"disc\"\nat_m = [0.0, 0.01]\n";
}

/// With friction enough it rolls: it gains 2/3 g sin 30, as a solid cylinder does, and friction is a third of what
/// pulls it down. With less it slips, and gains g (sin 30 - mu cos 30). Its rim of 64 edges rolls over each.
TEST(RollingDisc, GainsSpeedAsASolidCylinderOnAnIncline) {
  const TemporaryFolder folder;
  (void)folder.write(whole_disc_msh("disc", 0.0, 0.01, 0.01, 16), "disc.msh");
  const double sine = 0.5, cosine = std::sqrt(0.75), weight_n = 7850.0 * std::numbers::pi * 1e-4 * 1e5;
  const auto rolls = [&](const std::string& protocol, double friction, double speed_m_s, double gain_m_s2, double off) {
    const RunResult run =
        run_text(disc_on_an_incline(friction, speed_m_s, protocol), folder, fmt::format("{}{}", protocol, friction));
    const History probes = read_history(run.folder + "/probes.csv");
    const auto& t = probes.at("time_s");
    for (std::size_t n = 5; n < t.size(); n += 5) {
      const double way_m = speed_m_s * t[n] + 0.5 * gain_m_s2 * t[n] * t[n];
      EXPECT_NEAR(probes.at("middle.displacement_x_m")[n] / way_m, 1.0, off) << protocol << ' ' << friction << ' ' << n;
    }
    const double end_s = run.column("time_s").back();
    EXPECT_NEAR(run.last("contact_impulse_n_s") / (weight_n * cosine * end_s), 1.0, 0.05) << protocol << ": it hops";
    EXPECT_LT(at_most(run, "momentum_error_max"), 1e-11) << protocol;
    EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-6) << protocol;
    EXPECT_LT(at_most(run, "energy_error_max"), 1e-3) << protocol;
    return run.last("friction_impulse_n_s") / (weight_n * sine * end_s);
  };
  EXPECT_NEAR(rolls("all_explicit", 0.5, 20.0, 2.0 / 3.0 * 1e5 * sine, 0.01), 1.0 / 3.0, 0.015);
  EXPECT_NEAR(rolls("all_implicit", 0.5, 20.0, 2.0 / 3.0 * 1e5 * sine, 0.01), 1.0 / 3.0, 0.015);
  EXPECT_NEAR(rolls("all_explicit", 0.1, 0.0, 1e5 * (sine - 0.1 * cosine), 2e-3), 0.1 * cosine / sine, 0.01);
}

/// The half of a ball that strikes a rigid plane askew, with top spin and with back spin.
std::string spinning_ball(const std::string& protocol, double spin_rad_s) {
  std::string text = with_key(with_absolute_meshes(config_text("oblique_ball")), "time", "end_s", "80e-6");
  text = replaced(text, "initial_velocity_m_s",
                  fmt::format("large_rotation = true\ninitial_angular_velocity_rad_s = [0.0, {}, 0.0]\n"
                              "initial_velocity_m_s",
                              spin_rad_s));
  if (protocol == "local_explicit") return text + "[coupling]\nprotocol = \"local_explicit\"\n";
  if (protocol != "all_explicit") return with_protocol(text, protocol);
  return replaced(text, "step_s = 1.8e-7", "safety_factor = 0.9") + "[coupling]\nprotocol = \"all_explicit\"\n";
}

/// With back spin it slips all the time. With top spin its surface hardly slides over the plane, and friction is less.
TEST(SpinningBall, SlipsWithBackSpinAndSticksWithTopSpinByEveryMethod) {
  const TemporaryFolder folder;
  std::vector<double> with_top_spin;
  for (const char* protocol : {"hughes_liu", "all_explicit", "local_explicit"}) {
    for (const double spin : {-60.0, 60.0}) {
      const RunResult run = run_text(spinning_ball(protocol, spin), folder, fmt::format("{}{}", protocol, spin));
      const double share = run.last("friction_impulse_n_s") / run.last("contact_impulse_n_s");
      if (spin > 0.0) {
        with_top_spin.push_back(share);
      } else {
        EXPECT_NEAR(std::abs(share) / 0.092, 1.0, 1e-3) << protocol << ": the surface also spreads sideways";
      }
      if (protocol != std::string("all_explicit")) expect_no_overlap(run, protocol);
      EXPECT_LT(at_most(run, "momentum_error_max"), 1e-10) << protocol;
      EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-7) << protocol;
      EXPECT_LT(at_most(run, "energy_error_max"), 1e-4) << protocol;
    }
  }
  EXPECT_LT(with_top_spin[1], 0.06);
  EXPECT_NEAR(with_top_spin[0] / with_top_spin[1], 1.0, 5e-3);
  EXPECT_NEAR(with_top_spin[2] / with_top_spin[1], 1.0, 5e-3);
}

/// Two discs of 20 mm that meet head on at 10 m/s.
std::string two_discs(const std::string& protocol, double spin_rad_s, const std::string& more = "") {
  const bool one_process = protocol.rfind("all_", 0) == 0 || protocol == "local_explicit";
  const std::string rest = one_process ? "" : "[partition]\nrule = \"auto\"\n";
  const auto body = [&](const char* name, double speed) {
    return fmt::format(R"([[body]]
name = "{0}"
material = {1}
mesh = {{ gmsh = "{0}.msh" }}
large_rotation = true
initial_angular_velocity_rad_s = {2}
initial_velocity_m_s = [0.0, {3}]
)",
                       name, steel, spin_rad_s, speed);
  };
  return fmt::format(R"(model = "plane_strain"
{}{}[contact]
surfaces = ["lower.rim", "upper.rim"]
normal = [0.0, 1.0]
{}[time]
step_s = {}
end_s = 3e-5
[coupling]
protocol = "{}"
{}{})",
                     body("lower", 5.0), body("upper", -5.0), rest, rest.empty() ? 4e-8 : 8e-8, protocol,
                     protocol == "fixed_point" ? "acceleration = \"aitken\"\n" : "", more);
}

void write_discs(const TemporaryFolder& folder, int lower_cells, int upper_cells) {
  (void)folder.write(whole_disc_msh("lower", 0.0, -0.01, 0.01, lower_cells), "lower.msh");
  (void)folder.write(whole_disc_msh("upper", 0.0, 0.01 + 1e-6, 0.01, upper_cells), "upper.msh");
}

/// Smooth discs that spin press each other as those that do not, whichever facets come by; the ledger is kept.
TEST(SpinningDiscs, PressAsIfTheyDidNotSpin) {
  const TemporaryFolder folder;
  write_discs(folder, 48, 52);
  const auto run = [&](double spin) {
    return run_text(replaced(two_discs("all_explicit", spin), "step_s = 4e-08", "step_s = 2e-8"), folder,
                    fmt::format("{}", spin));
  };
  const RunResult still = run(0.0);
  for (const double spin : {500.0, 2000.0}) {
    const RunResult spins = run(spin);
    EXPECT_NEAR(spins.largest("contact_force_n") / still.largest("contact_force_n"), 1.0, 0.03) << spin;
    EXPECT_NEAR(spins.last("contact_impulse_n_s") / still.last("contact_impulse_n_s"), 1.0, 5e-3) << spin;
    EXPECT_LT(at_most(spins, "energy_error_max"), 1e-3) << spin;
    EXPECT_LT(at_most(spins, "momentum_error_max"), 1e-13) << spin;
    EXPECT_LT(at_most(spins, "angular_momentum_error_max"), 1e-4) << spin;
  }
}

/// The explicit and the implicit part of a body each have a frame of their own.
TEST(SpinningDiscs, PressAlikeByEveryMethod) {
  const TemporaryFolder folder;
  write_discs(folder, 24, 28);
  const RunResult expected = run_text(two_discs("all_explicit", 500.0), folder, "all_explicit");
  for (const char* protocol :
       {"hughes_liu", "kim", "fixed_point", "prakash_hjelmstad", "all_implicit", "local_explicit"}) {
    const RunResult run = run_text(two_discs(protocol, 500.0), folder, protocol);
    EXPECT_NEAR(run.largest("contact_force_n") / expected.largest("contact_force_n"), 1.0, 0.01) << protocol;
    EXPECT_NEAR(run.last("contact_impulse_n_s") / expected.last("contact_impulse_n_s"), 1.0, 1e-3) << protocol;
    EXPECT_LT(at_most(run, "angular_momentum_error_max"), 2e-4) << protocol;
    expect_no_overlap(run, protocol);
    const bool keeps_momentum = std::string(protocol) != "kim";  // no protocol of staggered sides does
    EXPECT_LT(at_most(run, "momentum_error_max"), keeps_momentum ? 1e-11 : 1e-3) << protocol;
    EXPECT_TRUE(run.summary.at("separation_time_s").is_number()) << protocol;
  }
}

TEST(SpinningDiscs, GoOnFromACheckpointToTheSameBytes) {
  const TemporaryFolder folder;
  write_discs(folder, 14, 16);
  for (const char* protocol : {"hughes_liu", "all_implicit", "all_explicit"}) {
    const RunResult whole =
        run_text(two_discs(protocol, 2000.0, "[checkpoint]\nevery_windows = 90\n[output]\nfields_every = 60\n"), folder,
                 protocol);
    (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
  }
}

TEST(SpinningDiscs, HaveTheSameBytesFromAnyNumberOfThreads) {
  const TemporaryFolder folder;
  write_discs(folder, 14, 16);
  const auto text = [&](int threads) {
    return two_discs("all_explicit", 2000.0) +
           fmt::format(
               "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"lower\", \"upper\"]\n"
               "threads = {}\n",
               threads);
  };
  const RunResult one = run_text(text(1), folder, "one"), three = run_text(text(3), folder, "three");
  EXPECT_EQ(file_text(one.folder + "/history.csv"), file_text(three.folder + "/history.csv"));
}

/// In the fields stress points where the body does: of a plate after a quarter of a turn along x.
TEST(SpinningPlate, HasFieldsThatTurnWithIt) {
  const TemporaryFolder folder;
  const double quarter_s = 0.25 * 2.0 * std::numbers::pi / 3000.0;
  const std::string text =
      replaced(plate(3000.0, "fields_every_s = 1.0\n"), "end_s = 8e-3", fmt::format("end_s = {}", quarter_s));
  std::string ordered = replaced(text, "fields_every_s = 1.0\n", "");
  ordered = replaced(ordered, "history_every = 40", "fields_every = 100000\nhistory_every = 40");
  const RunResult run = run_text(ordered, folder);
  const auto windows = run.summary.at("windows").get<int>();
  const auto fields = field_files(run.folder, "explicit", windows);
  const auto along = vtu_component(fields, "stress", "xx"), across = vtu_component(fields, "stress", "yy"),
             strain = vtu_component(fields, "strain", "xx"), von_mises = vtu_array(fields, "von_mises");
  double sum_along = 0.0, sum_across = 0.0, sum_strain = 0.0;
  for (std::size_t e = 0; e < along.size(); ++e) {
    sum_along += along[e];
    sum_across += across[e];
    sum_strain += strain[e];
    EXPECT_LT(von_mises[e], 2e8) << "no stress of the turn";
  }
  EXPECT_GT(sum_along, 4.0 * std::abs(sum_across));
  EXPECT_GT(sum_strain, 0.0);
}

/// A brick of 20 x 10 mm that stands on its corner, and a plate under it.
std::string falling_brick(bool on_plate) {
  return fmt::format(
      R"(model = "plane_strain"
[[body]]
name = "brick"
material = {0}
mesh = {{ gmsh = "brick.msh" }}
large_rotation = true
initial_velocity_m_s = [0.0, -1.0]
{1}[contact]
surfaces = {2}
[time]
safety_factor = 0.8
end_s = 3e-5
[coupling]
protocol = "all_explicit"
)",
      steel,
      on_plate ? fmt::format("[[body]]\nname = \"plate\"\nmaterial = {}\nmesh = {{ gmsh = \"plate.msh\" }}\n", steel)
               : "",
      on_plate ? "[\"plate.high\", \"brick.rim\"]"
               : "[\"brick.rim\", \"rigid_plane\"]\nrigid_place_m = [0.0, 0.0]\nnormal = [0.0, -1.0]");
}

/// A corner presses along the normal of what it meets, whichever mesh is finer: sideways nothing happens, and the
/// impulse turns the brick by its arm.
TEST(BrickOnItsCorner, IsTurnedByTheArmOfTheImpulse) {
  const TemporaryFolder folder;
  const double angle = std::numbers::pi / 6.0;
  const double c = std::cos(angle), s = std::sin(angle), arm_m = -0.01 * c + 0.005 * s,
               lowest = -0.01 * s - 0.005 * c;  // of the corner, from the middle
  std::vector<double> impulses;
  for (const auto& [brick, plate] : {std::pair{12, 0}, {12, 30}, {12, 60}, {24, 30}}) {
    (void)folder.write(brick_msh("brick", 0.0, -lowest + 1e-7, 0.02, 0.01, brick, brick / 2, angle), "brick.msh");
    if (plate > 0) (void)folder.write(brick_msh("plate", 0.001, -0.004, 0.03, 0.008, plate, plate / 4), "plate.msh");
    const RunResult run = run_text(falling_brick(plate > 0), folder, fmt::format("b{}_{}", brick, plate));
    const double impulse = run.last("contact_impulse_n_s");
    if (plate > 0) impulses.push_back(impulse);
    EXPECT_GT(impulse, 0.5);
    EXPECT_LT(std::abs(run.last("momentum_t_kg_m_s")), 1e-13);
    EXPECT_LT(std::abs(run.last("normal_impulse_t_n_s")), 1e-12);
    EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-4);
    if (plate > 0) continue;
    EXPECT_NEAR(run.last("angular_momentum_z_kg_m2_s") / (arm_m * impulse), 1.0, 2e-3);
  }
  EXPECT_NEAR(impulses[1] / impulses[0], 1.0, 0.02);
  EXPECT_NEAR(impulses[2] / impulses[0], 1.0, 0.02);
}

/// The brick carries the rows: the corner of what lies below it is felt between its nodes, too, and not when it has
/// sunk in as far as the next one.
TEST(BrickOnACorner, FeelsItBetweenItsNodes) {
  const TemporaryFolder folder;
  const double corner = 0.005 * std::numbers::sqrt2;
  (void)folder.write(brick_msh("wedge", 0.0, -corner, 0.01, 0.01, 8, 8, std::numbers::pi / 4.0), "wedge.msh");
  std::vector<double> impulses;
  for (const double aside : {0.0, 0.02 / 24.0}) {  // under a node, and between two
    (void)folder.write(brick_msh("brick", aside, 0.005 + 1e-7, 0.02, 0.01, 12, 6), "brick.msh");
    const std::string text =
        replaced(replaced(replaced(falling_brick(true), "plate.msh", "wedge.msh"), "\"plate\"", "\"wedge\""),
                 "[\"plate.high\", \"brick.rim\"]", "[\"brick.rim\", \"wedge.rim\"]\nnormal = [0.0, -1.0]");
    const RunResult run = run_text(text, folder, fmt::format("{}", impulses.size()));
    impulses.push_back(run.last("contact_impulse_n_s"));
    EXPECT_LT(std::abs(run.last("momentum_t_kg_m_s")), 1e-13);
    EXPECT_LT(std::abs(run.last("normal_impulse_t_n_s")), 0.02 * impulses.back());
    EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-4);
  }
  EXPECT_GT(impulses[0], 0.3);
  EXPECT_NEAR(impulses[1] / impulses[0], 1.0, 0.05);
}

/// A block of 40 x 20 mm and 1 kg that a table's edge, at the origin, turns while it slides off without friction: x, y
/// of its centre and its angle, with the reaction along the normal of its lower side for as long as that presses.
struct RigidSlidingBlock {
  Vector q{-0.005, 0.01, 0.0}, v{1.0, 0.0, 0.0};

  [[nodiscard]] static Vector acceleration(const Vector& at, const Vector& rate) {
    const double c = std::cos(at[2]), s = std::sin(at[2]), inertia = (0.04 * 0.04 + 0.02 * 0.02) / 12.0;
    const Vector free{0.0, -9.81, 0.0}, inverse_mass{1.0, 1.0, 1.0 / inertia};
    if (at[0] < 0.0 && std::abs(at[2]) < 1e-9) return Vector(3);  // it rests on the table
    const Vector along{s, -c, c * at[0] + s * at[1]};             // of the gap's rate
    const Vector turns{c * rate[2], s * rate[2], (-s * at[0] + c * at[1]) * rate[2] + c * rate[0] + s * rate[1]};
    const double force = -((along * free).sum() + (turns * rate).sum()) / (along * inverse_mass * along).sum();
    const bool on_edge = -at[0] * c - at[1] * s >= -0.02;
    if (!on_edge || force * along[1] < 0.0) return free;
    return free + force * inverse_mass * along;
  }
  void step(double dt) {  // Heun's
    const Vector a = acceleration(q, v), to = q + dt * v, rate = v + dt * a;
    q += 0.5 * dt * (v + rate);
    v += 0.5 * dt * (a + acceleration(to, rate));
  }
};

/// The edge of the table presses on the lower side of the block, between its nodes, until the block's own edge has
/// passed. Bodies are as stiff as a rigid one is in a step that the test can pay.
TEST(BlockOverAnEdge, TopplesAsARigidOne) {
  const TemporaryFolder folder;
  (void)folder.write(brick_msh("block", -0.005, 0.01, 0.04, 0.02, 16, 8), "block.msh");
  (void)folder.write(brick_msh("table", -0.05, -0.01, 0.1, 0.02, 40, 8), "table.msh");
  const RunResult run = run_text(R"(model = "plane_strain"
[[body]]
name = "block"
material = { youngs_modulus_pa = 1e8, poisson_ratio = 0.3, density_kg_m3 = 1000.0 }
mesh = { gmsh = "block.msh" }
large_rotation = true
initial_velocity_m_s = [1.0, 0.0]
gravity_m_s2 = [0.0, -9.81]
[[body]]
name = "table"
material = { youngs_modulus_pa = 1e8, poisson_ratio = 0.3, density_kg_m3 = 1000.0 }
mesh = { gmsh = "table.msh" }
[[body.support]]
surface = "low"
fixed = ["x", "y"]
[contact]
surfaces = ["table.high", "block.rim"]
[time]
safety_factor = 0.8
end_s = 0.06
[coupling]
protocol = "all_explicit"
[output]
history_every = 50
probes_every = 50
[[output.probe]]
name = "middle"
body = "block"
at_m = [-0.005, 0.01]
[[output.probe]]
name = "right"
body = "block"
at_m = [0.01, 0.01]
)",
                                 folder);
  RigidSlidingBlock rigid;
  for (int n = 0; n < 60000; ++n) rigid.step(1e-6);
  const History probes = read_history(run.folder + "/probes.csv");
  const auto last = [&](const char* name) { return probes.at(name).back(); };
  const double angle = std::atan2(last("right.displacement_y_m") - last("middle.displacement_y_m"),
                                  0.015 + last("right.displacement_x_m") - last("middle.displacement_x_m"));
  EXPECT_NEAR(-0.005 + last("middle.displacement_x_m"), rigid.q[0], 1e-4);
  EXPECT_NEAR(0.01 + last("middle.displacement_y_m"), rigid.q[1], 6e-4) << "of 10.6 mm that it falls";
  EXPECT_NEAR(angle / rigid.q[2], 1.0, 0.08);
  EXPECT_LT(at_most(run, "energy_error_max"), 2e-3);
}

/// Plastic strain lies in the frame of the part.
TEST(SpinningDisc, ThatYieldsDentsAlikeByEveryMethod) {
  const TemporaryFolder folder;
  (void)folder.write(whole_disc_msh("disc", 0.0, 0.01 + 1e-6, 0.01, 16), "disc.msh");
  std::vector<double> work_j;
  for (const char* protocol : {"all_explicit", "all_implicit"}) {
    const std::string text = replaced(spinning_disc(2000.0, 0.2, protocol), "density_kg_m3 = 7850.0 }",
                                      "density_kg_m3 = 7850.0, plasticity = { yield_stress_pa = 4e8, hardening_pa = "
                                      "2e9 } }");
    const RunResult run = run_text(text, folder, protocol);
    work_j.push_back(run.last("plastic_work_j"));
    EXPECT_LT(at_most(run, "energy_error_max"), 5e-3) << protocol;
    EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-5) << protocol;
    EXPECT_LT(at_most(run, "momentum_error_max"), 1e-10) << protocol;
  }
  EXPECT_GT(work_j[0], 5.0);
  EXPECT_NEAR(work_j[1] / work_j[0], 1.0, 0.01);
}

/// A brick of 10 x 20 mm that stands on its corner, spins and falls over onto a rigid plane. Elements of 1 mm at that
/// corner, or else higher up, are divided by six.
std::string brick_of_two_sizes(const std::string& protocol, bool fine_at_corner, bool yields = false) {
  const bool small = protocol == "all_explicit";
  const std::string text = fmt::format(
      R"(model = "plane_strain"
[[body]]
name = "brick"
material = {{ youngs_modulus_pa = 2e9, poisson_ratio = 0.3, density_kg_m3 = 2000.0{} }}
large_rotation = true
initial_velocity_m_s = [0.0, -0.4]
initial_angular_velocity_rad_s = 100.0
gravity_m_s2 = [0.0, -1000.0]
[body.mesh]
length_m = 0.02
height_m = 0.01
elements = [20, 10]
refine = [{{ from_m = {}, ratio = 6 }}]
place = {{ turned_deg = 30.0, moved_m = [0.0, 1e-5] }}
[contact]
surfaces = ["brick.inner", "rigid_plane"]
rigid_place_m = [0.0, 0.0]
normal = [0.0, -1.0]
friction_coefficient = 0.2
[time]
{}
end_s = 2e-3
[output]
history_every = 20
fields_every = {}
[checkpoint]
every_windows = {}
[coupling]
protocol = "{}"
)",
      yields ? ", plasticity = { yield_stress_pa = 4e7, hardening_pa = 2e8 }" : "",
      fine_at_corner ? "[0.0, 0.0], to_m = [0.004, 0.004]" : "[0.003, 0.0132], to_m = [0.007, 0.017]",
      small ? "safety_factor = 0.9" : "step_s = 3.6e-7", small ? 20000 : 4000, small ? 13000 : 2000, protocol);
  return protocol == "hughes_liu" ? text + "[partition]\nrule = \"auto\"\n" : text;
}

/// Fine elements of a body that turns by a quarter take small steps in its frame, inside the contact and away from it:
/// they do what all elements do in steps that short, and the book of its loads is right.
TEST(BrickOfTwoSizes, TopplesInSmallStepsAsInOnesOfAll) {
  const TemporaryFolder folder;
  struct Case {
    const char* protocol;
    bool fine_at_corner, yields;
  };
  for (const auto& [protocol, fine_at_corner, yields] :
       {Case{"local_explicit", true, false}, Case{"local_explicit", true, true}, Case{"local_explicit", false, false},
        Case{"hughes_liu", false, false}}) {
    const std::string name = fmt::format("{}{}{}", protocol, fine_at_corner, yields);
    const RunResult all =
        run_text(brick_of_two_sizes("all_explicit", fine_at_corner, yields), folder, name + "_in_all");
    const RunResult run = run_text(brick_of_two_sizes(protocol, fine_at_corner, yields), folder, name);
    EXPECT_NEAR(run.last("contact_impulse_n_s") / all.last("contact_impulse_n_s"), 1.0, 1e-3) << name;
    EXPECT_NEAR(run.last("friction_impulse_n_s") / all.last("friction_impulse_n_s"), 1.0, 3e-3) << name;
    EXPECT_LT(at_most(run, "momentum_error_max"), 1e-11) << name;
    EXPECT_LT(at_most(run, "angular_momentum_error_max"), 1e-7) << name;
    EXPECT_LT(at_most(run, "energy_error_highest"), 1e-8) << name;
    EXPECT_GT(run.summary.at("energy_error_lowest").get<double>(), -2e-3) << name;
    if (!yields) continue;
    EXPECT_NEAR(run.last("plastic_work_j") / all.last("plastic_work_j"), 1.0, 0.01);
  }
}

TEST(BrickOfTwoSizes, GoesOnFromACheckpointToTheSameBytes) {
  const TemporaryFolder folder;
  for (const char* protocol : {"local_explicit", "hughes_liu"}) {
    const bool fine_at_corner = protocol == std::string("local_explicit");
    const RunResult whole = run_text(brick_of_two_sizes(protocol, fine_at_corner, true), folder, protocol);
    (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
  }
}

/// A support along one direction is none in the frame of a body that turns, but for the plane that it turns about.
TEST(BrickOfTwoSizes, IsRefusedWhereItIsHeldInSomeDirections) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text) {
    const auto outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string());
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_THAT(outcome.error,
                AllOf(HasSubstr("body.brick.large_rotation: found large_rotation of a body whose node at ("),
                      HasSubstr("is held in some directions"), HasSubstr("allowed: a smaller step")));
  };
  const char* const roller = "[[body.support]]\nsurface = \"end\"\nfixed = [\"x\"]\n[contact]";
  refused(replaced(brick_of_two_sizes("local_explicit", true), "[contact]", roller));
  refused(replaced(brick_of_two_sizes("hughes_liu", false), "[contact]", roller));
}

TEST(TurningBody, IsRefusedWhereSomethingKeepsItsDirection) {
  const TemporaryFolder folder;
  write_discs(folder, 6, 8);
  (void)folder.write(whole_disc_msh("disc", 0.0, 0.01, 0.01, 6), "disc.msh");
  const auto refused = [&](const std::string& text, const char* found, const char* allowed) {
    const auto outcome = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string());
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_THAT(outcome.error, AllOf(HasSubstr(found), HasSubstr("allowed: "), HasSubstr(allowed)));
  };
  const auto stability = run_command({ricochet_binary(), "stability", folder.write(two_discs("hughes_liu", 10.0))},
                                     folder.path().string());
  EXPECT_EQ(stability.code, 2) << stability.out;
  EXPECT_THAT(stability.error, HasSubstr("as no body that yields or turns goes on"));
  const std::string discs = two_discs("all_explicit", 10.0);
  refused(replaced(plate(10.0), "[time]", "[[body.absorbing]]\nsurface = \"end\"\nwave = \"bar\"\n[time]"),
          "body.plate.large_rotation: found large_rotation of a body with an absorbing surface",
          "no absorbing surface");
  refused(replaced(discs, "[contact]", "[[body.support]]\nsurface = \"rim\"\nfixed = [\"x\"]\n[contact]"),
          "body.upper.large_rotation: found large_rotation of a body with a support at its contact surface",
          "supports away from the contact surface");
  refused(replaced(plate(10.0), "elements = [4, 12]", "elements = [4, 12], periodic_across = true"),
          "body.plate.large_rotation: found large_rotation of a periodic mesh", "periodic_across = false");
  refused(two_discs("belytschko_mullen", 10.0), "found large_rotation under \"belytschko_mullen\"",
          "or bodies that turn on the implicit side alone");
  refused(two_discs("gravouil_combescure", 10.0), "found large_rotation under \"gravouil_combescure\"",
          "\"hughes_liu\"");
  refused(replaced(plate(10.0), "large_rotation = true\n", ""), "initial_angular_velocity_rad_s",
          "large_rotation = true beside it");
  refused(replaced(replaced(spinning_disc(10.0, 0.0), "rigid_plane", "rigid_cylinder"), "normal = [0.0, -1.0]\n",
                   "normal = [0.0, -1.0]\nrigid_radius_m = 0.1\n"),
          "which may slide along a rigid sphere or cylinder", "a rigid plane");
}

}  // namespace
}  // namespace ricochet::test
