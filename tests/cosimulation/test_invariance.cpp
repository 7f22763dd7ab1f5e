#include <fmt/format.h>

#include <cmath>

#include "tests/support/run.hpp"

// No result changes with these: the transport, how explicit bodies are spread over processes, the size of everything.

namespace ricochet::test {
namespace {

std::string short_kim() {
  std::string text = with_key(config_text("kim_impact"), "output", "fields_every", "0");
  return with_key(text, "coupling", "resynchronise_every", "70");
}

std::string participants(const std::string& first, const std::string& second) {
  return "\n[[participant]]\nname = \"" + first + "\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n" +
         "\n[[participant]]\nname = \"" + second + "\"\nrole = \"explicit\"\nbodies = [\"carbide\"]\n" +
         "\n[[participant]]\nname = \"contact\"\nrole = \"implicit\"\n";
}

std::string history_of(const RunResult& run) { return file_text(run.folder + "/history.csv"); }

TEST(Invariance, TransportAndNumberOfExplicitParticipantsGiveBitIdenticalHistories) {
  const TemporaryFolder folder;
  const RunResult shm = run_text(with_key(short_kim(), "coupling", "transport", "\"shm\""), folder, "shm");
  const RunResult zmq = run_text(with_key(short_kim(), "coupling", "transport", "\"zmq\""), folder, "zmq");
  const RunResult tcp = run_text(with_key(short_kim(), "coupling", "transport", "\"tcp\""), folder, "tcp");
  const RunResult two = run_text(
      with_key(short_kim(), "coupling", "transport", "\"shm\"") + participants("left", "right"), folder, "two");
  const RunResult again = run_text(short_kim(), folder, "shm");  // into the directory of the first run
  ASSERT_GT(history_of(shm).size(), 100000U);
  for (const auto* other : {&zmq, &tcp, &two, &again}) {
    EXPECT_TRUE(history_of(shm) == history_of(*other)) << other->folder;
  }
  for (const auto& [run, transport] : {std::pair{&shm, "shm"}, {&zmq, "zmq"}, {&tcp, "tcp"}, {&two, "shm"}}) {
    for (const auto& process : run->summary.at("processes")) {
      EXPECT_EQ(process.at("transport"), process.at("name") == "coupler" ? "" : transport);
    }
  }
  EXPECT_EQ(two.summary.at("processes").size(), 4U);
}

TEST(Invariance, IncrementsDoNotDriftFromTheAbsoluteValues) {
  const TemporaryFolder folder;
  const RunResult often = run_text(short_kim(), folder, "often");
  EXPECT_LT(often.summary.at("largest_drift").get<double>(), 1e-12);
  const RunResult never = run_text(with_key(short_kim(), "coupling", "resynchronise_every", "0"), folder, "never");
  const auto &a = often.column("velocity_mean_steel_m_s"), &b = never.column("velocity_mean_steel_m_s");
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-8) << i;
}

/// Two plates that rub, with all lengths and times `scale` times as large.
std::string rubbing_plates(double scale) {
  const std::string body = R"([[body]]
name = "{0}"
material = {{ youngs_modulus_pa = {1}, poisson_ratio = 0.3, density_kg_m3 = 7860.0 }}
thickness_m = {2:.17g}
initial_velocity_m_s = [{3}, {4}]
mesh = {{ start_m = {5:.17g}, length_m = {6:.17g}, height_m = {7:.17g}, elements = [{8}, 6] }}
)";
  return "model = \"plane_strain\"\n" +
         fmt::format(fmt::runtime(body), "low", "2e11", 0.01 * scale, 0.0, 0.0, -0.006 * scale, 0.006 * scale,
                     0.004 * scale, 4) +
         fmt::format(fmt::runtime(body), "high", "7e10", 0.01 * scale, 0.5, -2.0, 0.0, 0.006 * scale, 0.004 * scale,
                     6) +
         fmt::format(
             "[contact]\nsurfaces = [\"low.end\", \"high.start\"]\nfriction_coefficient = 0.3\n"
             "initial_gap_m = {:.17g}\n[partition]\nimplicit_length_m = {{ low = {:.17g}, high = {:.17g} }}\n"
             "[time]\nstep_s = {:.17g}\nend_s = {:.17g}\n",
             1e-7 * scale, 0.002 * scale, 0.002 * scale, 8e-8 * scale, 8e-6 * scale);
}

/// A block that spins and comes down on its edge.
std::string tumbling_block(double scale) {
  return fmt::format(R"(model = "plane_strain"
[[body]]
name = "block"
large_rotation = true
material = {{ youngs_modulus_pa = 7e10, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
thickness_m = {3:.17g}
initial_velocity_m_s = [1.0, -3.0]
initial_angular_velocity_rad_s = {0:.17g}
mesh = {{ length_m = {2:.17g}, height_m = {2:.17g}, elements = [6, 6], place = {{ turned_deg = 20.0 }} }}
[contact]
surfaces = ["block.outside", "rigid_plane"]
normal = [0.0, -1.0]
friction_coefficient = 0.2
initial_gap_m = {1:.17g}
[time]
step_s = {1:.17g}
end_s = {4:.17g}
)",
                     200.0 / scale, 5e-8 * scale, 0.004 * scale, 0.003 * scale, 2e-5 * scale);
}

/// Lengths and times in a unit of a column, of masses that go with the cube of a length.
int power_of_scale(const std::string& column) {
  const std::string name = column.substr(0, column.find('/'));
  for (const auto& [unit, power] : {std::pair{"_kg_m2_s", 4},
                                    {"_kg_m_s", 3},
                                    {"_n_s", 3},
                                    {"_m_s", 0},
                                    {"_rad_s", -1},
                                    {"_pa", 0},
                                    {"_n", 2},
                                    {"_j", 3},
                                    {"_m", 1},
                                    {"_s", 1}})
    if (name.ends_with(unit)) return power;
  return 0;
}

/// No tolerance, threshold or limit has a unit: a scene of other lengths and times computes the same bits. Powers of
/// four, since Cholesky's factor has roots, and no hexahedra, whose modes of several units are eliminated in the order
/// of their size. Only what tells the round-off of a solution may differ.
void expect_same_bits_at_any_size(std::string (*scene)(double), const char* protocol) {
  const TemporaryFolder folder;
  const RunResult as_is = run_text(with_protocol(scene(1.0), protocol), folder, "as_is");
  for (const int exponent : {-12, 10}) {
    const double scale = std::ldexp(1.0, exponent);
    const RunResult scaled = run_text(with_protocol(scene(scale), protocol), folder, "scaled");
    ASSERT_GT(as_is.largest("contact_force_n"), 0.0);
    for (const auto& [name, values] : as_is.history) {
      if (name == "contact_residual") continue;
      const auto& others = scaled.column(name);
      ASSERT_EQ(values.size(), others.size());
      for (std::size_t i = 0; i < values.size(); ++i)
        ASSERT_EQ(std::ldexp(values[i], exponent * power_of_scale(name)), others[i])
            << protocol << ", " << name << ", row " << i << ", scale 2^" << exponent;
    }
  }
}

TEST(Invariance, NoToleranceHasAUnit) {
  for (const char* const protocol : {"hughes_liu", "kim", "belytschko_mullen", "prakash_hjelmstad",
                                     "gravouil_combescure", "fixed_point", "all_implicit", "all_explicit"})
    expect_same_bits_at_any_size(rubbing_plates, protocol);
  for (const char* const protocol : {"hughes_liu", "all_implicit", "all_explicit"})
    expect_same_bits_at_any_size(tumbling_block, protocol);
}

/// A plate that turns comes down on another one with which its edges are flush; `mirror`: -1 for the mirror image.
std::string turning_plate(double mirror) {
  const double h_m = 0.016, from_m = mirror > 0.0 ? 0.0 : h_m - 0.0064;
  return fmt::format(R"(model = "solid"
[[body]]
name = "low"
rigid = true
material = {{ youngs_modulus_pa = 20e9, poisson_ratio = 0.0, density_kg_m3 = 2700.0 }}
mesh = {{ length_m = 0.006, height_m = 0.016, width_m = 0.016, elements = [3, 2, 2], place = {{ moved_m = [-0.008, -0.008, 0.0] }} }}
support = [{{ surface = "start", fixed = ["x", "y", "z"] }}]
[[body]]
name = "high"
large_rotation = true
initial_velocity_m_s = [0.0, 0.0, -5.0]
initial_angular_velocity_rad_s = [100.0, {0}, {1}]
material = {{ youngs_modulus_pa = 20e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
mesh = {{ length_m = 0.004, height_m = 0.016, width_m = 0.016, elements = [5, 4, 4], refine = [{{ from_m = [{2}, 0.0, 0.0], to_m = [{3}, 0.0096, 0.002], ratio = 2 }}], place = {{ moved_m = [-0.008, -0.008, 0.0062] }} }}
[contact]
surfaces = ["low.end", "high.start"]
friction_coefficient = 0.3
[coupling]
protocol = "all_explicit"
[time]
step_s = 6e-8
end_s = 5e-5
)",
                     200.0 * mirror, 50.0 * mirror, from_m, from_m + 0.0064);
}

/// Rows of a body that turns alone have no direction to run ahead in but that of round-off.
TEST(Invariance, AMirrorImageHasTheSameForces) {
  const TemporaryFolder folder;
  const RunResult one = run_text(turning_plate(1.0), folder, "one"),
                  other = run_text(turning_plate(-1.0), folder, "other");
  for (const char* const name : {"contact_force_n", "energy_strain_j", "energy_friction_j"}) {
    const auto &x = one.column(name), &y = other.column(name);
    ASSERT_GT(one.largest(name), 0.0);
    for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(x[i], y[i], 1e-7 * one.largest(name)) << name << " " << i;
  }
}

}  // namespace
}  // namespace ricochet::test
