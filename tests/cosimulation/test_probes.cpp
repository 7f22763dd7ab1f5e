#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <numbers>

#include "tests/support/same_results.hpp"

// [[output.probe]] and [[output.gauge]], probes.csv: against exact waves, however bodies are spread over processes.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

History probes(const RunResult& run) { return read_history(run.folder + "/probes.csv"); }

double mean(const History& table, const std::string& column, double begin_s, double end_s) {
  const auto &time = table.at("time_s"), &values = table.at(column);
  double sum = 0.0;
  int rows = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < begin_s || time[i] > end_s) continue;
    sum += values[i];
    ++rows;
  }
  return sum / rows;
}

double largest(const std::vector<double>& values) {
  double found = 0.0;
  for (const double value : values) found = std::max(found, std::abs(value));
  return found;
}

// -- A split Hopkinson bar: the striker sends rho c v / 2 = 198.1 MPa of compression into the bar, for 2 L / c.

const double wave_speed_m_s = std::sqrt(200e9 / 7850.0);
const double incident_pa = 7850.0 * wave_speed_m_s * 10.0 / 2.0;

std::string hopkinson(const std::string& model, const std::string& gauges) {
  const bool bar = model == "bar";
  const std::string material = bar ? "{ youngs_modulus_pa = 200e9, density_kg_m3 = 7850.0 }"
                                   : "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.29, density_kg_m3 = 7850.0 }";
  const std::string across = bar ? "" : "radius_m = 0.003, ";
  const auto elements = [&](int along) { return bar ? fmt::format("{}", along) : fmt::format("[3, {}]", along); };
  return fmt::format(R"(model = "{}"
[[body]]
name = "striker"
material = {}
{}mesh = {{ start_m = -0.1, length_m = 0.1, {}elements = {} }}
initial_velocity_m_s = {}
[[body]]
name = "incident"
material = {}
{}mesh = {{ length_m = 0.3, {}elements = {} }}
[contact]
surfaces = ["striker.end", "incident.start"]
[partition]
implicit_length_m = {{ striker = 0.02, incident = 0.02 }}
[time]
step_s = 1.5e-7
end_s = 8e-5
[output]
{})",
                     model, material, bar ? "area_m2 = 2.8e-5\n" : "", across, elements(100),
                     bar ? "[10.0]" : "[0.0, 10.0]", material, bar ? "area_m2 = 2.8e-5\n" : "", across, elements(300),
                     gauges);
}

TEST(Gauge, OfAHopkinsonBarSeesHalfOfWhatTheStrikerBrings) {
  const TemporaryFolder folder;
  for (const std::string model : {"bar", "axisymmetric"}) {
    std::string gauges = "[[output.gauge]]\nname = \"g\"\nbody = \"incident\"\nsection_m = 0.15\nlength_m = 0.003\n";
    if (model != "bar") gauges += replaced(gauges, "\"g\"", "\"side\"") + "surface = \"outer\"\nrise_time_s = 2e-6\n";
    const History table = probes(run_text(hopkinson(model, gauges), folder, model));
    EXPECT_NEAR(incident_pa, 198.1e6, 0.05e6);
    const double from = 0.15 / wave_speed_m_s + 6e-6, to = 0.35 / wave_speed_m_s - 6e-6;
    for (const std::string name : {"g", "side"}) {
      if (table.count(name + ".strain") == 0) continue;
      EXPECT_NEAR(mean(table, name + ".stress_pa", from, to), -incident_pa, 0.01 * incident_pa) << model << name;
      EXPECT_NEAR(mean(table, name + ".strain", from, to), -incident_pa / 200e9, 0.01 * incident_pa / 200e9)
          << model << name;
      EXPECT_LT(std::abs(mean(table, name + ".stress_pa", 0.0, 0.13 / wave_speed_m_s)), 1e-3 * incident_pa);
    }
    EXPECT_EQ(table.size(), model == "bar" ? 3U : 5U);
  }
}

/// y' = (x - y) / tau takes 10 to 90 % of a step in tau ln 9: told of the same windows, the filtered gauge is what the
/// filter makes of the other.
TEST(Gauge, WithARiseTimeIsTheFilterOfFirstOrderOfTheOther) {
  const TemporaryFolder folder;
  const std::string gauge = "[[output.gauge]]\nname = \"{}\"\nbody = \"incident\"\nsection_m = 0.1\n";
  const std::string both = replaced(gauge, "{}", "fast") + replaced(gauge, "{}", "slow") + "rise_time_s = 1e-5\n";
  const History table = probes(run_text(hopkinson("bar", both), folder));
  const auto &time = table.at("time_s"), &fast = table.at("fast.strain"), &slow = table.at("slow.strain");
  const double tau = 1e-5 / std::log(9.0);
  double y = 0.0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    constexpr int parts = 1000;  // of a window, each by the trapezoidal rule
    const double h = (time[i] - time[i - 1]) / parts;
    for (int k = 0; k < parts; ++k) {
      const double x = fast[i - 1] + (fast[i] - fast[i - 1]) * (k + 0.5) / parts;
      y = (y * (1.0 - 0.5 * h / tau) + x * h / tau) / (1.0 + 0.5 * h / tau);
    }
    ASSERT_NEAR(slow[i], y, 1e-8 * largest(fast)) << time[i];
  }
  const History seldom = probes(run_text(hopkinson("bar", "probes_every = 7\n" + both), folder, "seldom"));
  ASSERT_EQ(seldom.at("time_s").size(), (time.size() - 1) / 7 + 1);
  for (std::size_t i = 0; i < seldom.at("time_s").size(); ++i) {
    EXPECT_EQ(seldom.at("time_s")[i], time[7 * i]);
    EXPECT_EQ(seldom.at("slow.strain")[i], slow[7 * i]) << "the filter has every window, whatever rows there are";
  }
}

// -- d'Alembert: a bar whose end moves as f(t) = A sin^4(pi t / T), u = f(t - x / c) until the wave comes back. The far
// end is implicit, for the sake of a contact that nothing ever meets.

constexpr double step_s = 1.125e-6, pulse_s = 360 * step_s, amplitude_m = 1e-5, speed_m_s = 1000.0;

struct Pulse {
  double u = 0.0, v = 0.0, a = 0.0;
};
Pulse pulse(double t) {
  if (t <= 0.0 || t >= pulse_s) return {};
  const double k = std::numbers::pi / pulse_s, s = std::sin(k * t), c = std::cos(k * t);
  return {amplitude_m * std::pow(s, 4), amplitude_m * 4 * k * std::pow(s, 3) * c,
          amplitude_m * 4 * k * k * (3 * s * s * c * c - std::pow(s, 4))};
}

std::string dalembert(const std::string& probes) {
  std::string times, factors;
  for (int i = 0; i <= 360; ++i) {
    times += fmt::format("{}{:.17g}", i ? ", " : "", i * step_s);
    factors += fmt::format("{}{:.17g}", i ? ", " : "", pulse(i * step_s).u / amplitude_m);
  }
  return fmt::format(R"(model = "bar"
[[body]]
name = "bar"
material = {{ youngs_modulus_pa = 1e9, density_kg_m3 = 1000.0 }}
area_m2 = 1e-4
mesh = {{ start_m = -1.0, length_m = 1.0, elements = 800 }}
[[body.prescribed]]
surface = "start"
component = "x"
displacement_m = {}
amplitude = {{ time_s = [{}], factor = [{}] }}
[contact]
surfaces = ["bar.end", "rigid_plane"]
initial_gap_m = 0.1
[partition]
implicit_length_m = {{ bar = 0.3 }}
[time]
step_s = {}
end_s = 1.1e-3
[output]
{})",
                     amplitude_m, times, factors, step_s, probes);
}

TEST(Probe, OfABarFollowsDAlembertInEveryProcess) {
  const TemporaryFolder folder;
  // Explicit, at the shared node, in the elements on either side of it, implicit.
  const std::map<std::string, double> places{
      {"out", 0.500625}, {"before", 0.699375}, {"shared", 0.7}, {"behind", 0.700625}, {"in", 0.850625}};
  std::string text;
  for (const auto& [name, x] : places)
    text += fmt::format("[[output.probe]]\nname = \"{}\"\nbody = \"bar\"\nat_m = [{}]\n", name, x - 1.0);
  const RunResult run = run_text(dalembert(text), folder);
  const History table = probes(run);
  EXPECT_EQ(table.at("time_s"), run.column("time_s"));
  EXPECT_EQ(table.size(), 1U + 6U * places.size());
  const double k = std::numbers::pi / pulse_s;
  const double v = amplitude_m * 4 * k * 0.325, a = amplitude_m * 4 * k * k;  // the largest there are
  for (const auto& [name, x] : places) {
    double u_error = 0.0, v_error = 0.0, a_error = 0.0, strain_error = 0.0, stress_error = 0.0;
    for (std::size_t i = 0; i < table.at("time_s").size(); ++i) {
      const Pulse exact = pulse(table.at("time_s")[i] - x / speed_m_s);
      const auto at = [&](const char* column) { return table.at(name + "." + column)[i]; };
      u_error = std::max(u_error, std::abs(at("displacement_x_m") - exact.u) / amplitude_m);
      v_error = std::max(v_error, std::abs(at("velocity_x_m_s") - exact.v) / v);
      a_error = std::max(a_error, std::abs(at("acceleration_x_m_s2") - exact.a) / a);
      strain_error = std::max(strain_error, std::abs(at("strain_xx") + exact.v / speed_m_s) / (v / speed_m_s));
      stress_error = std::max(stress_error, std::abs(at("stress_xx_pa") + 1e9 * exact.v / speed_m_s));
      EXPECT_EQ(at("von_mises_pa"), std::abs(at("stress_xx_pa")));
    }
    EXPECT_LT(u_error, 2e-3) << name;
    EXPECT_LT(v_error, 2e-3) << name;
    EXPECT_LT(a_error, 2e-3) << name;
    if (name != "shared") {  // there it is that of one of the two elements
      EXPECT_LT(strain_error, 2e-3) << name;
    }
    EXPECT_NEAR(stress_error, 1e9 * strain_error * v / speed_m_s, 1e-6 * 1e9 * v / speed_m_s) << name;
  }
}

/// A bar pressed from all sides, so slowly that nothing swings: its strain is that of statics, -p (1 - 2 nu) / E.
TEST(Probe, OfASlowPressureSeesTheStaticStrain) {
  const TemporaryFolder folder;
  std::string times, factors;
  for (int i = 0; i <= 100; ++i) {
    times += fmt::format("{}{:.17g}", i ? ", " : "", 4e-6 * i);
    factors += fmt::format("{}{:.17g}", i ? ", " : "", std::pow(std::sin(0.005 * std::numbers::pi * i), 2));
  }
  std::string loads;
  for (const char* surface : {"start", "end", "outer"})
    loads += fmt::format(
        "[[body.traction]]\nsurface = \"{}\"\npressure_pa = 2e7\namplitude = {{ time_s = [{}], factor = [{}] }}\n",
        surface, times, factors);
  const RunResult run = run_text(fmt::format(R"(model = "axisymmetric"
[[body]]
name = "rod"
material = {{ youngs_modulus_pa = 70e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }}
mesh = {{ start_m = -0.02, length_m = 0.02, radius_m = 0.005, elements = [4, 16] }}
{}[contact]
surfaces = ["rod.end", "rigid_plane"]
initial_gap_m = 0.01
[partition]
implicit_length_m = {{ rod = 0.005 }}
[time]
step_s = 1.2e-7
end_s = 4.5e-4
[output]
probes_every_s = 6e-7
[[output.probe]]
name = "out"
body = "rod"
at_m = [0.002, -0.0133]
[[output.probe]]
name = "in"
body = "rod"
at_m = [0.0, -0.001]
[[output.gauge]]
name = "gauge"
body = "rod"
section_m = -0.005
length_m = 0.004
)",
                                             loads),
                                 folder);
  const History table = probes(run);
  EXPECT_NEAR(table.at("time_s")[1], 6e-7, 1e-15);
  const double strain = -2e7 * 0.4 / 70e9;
  for (const std::string name : {"out", "in"}) {
    for (const char* column : {"strain_rr", "strain_tt", "strain_zz"})
      EXPECT_NEAR(mean(table, name + "." + column, 4.2e-4, 4.5e-4), strain, 2e-3 * std::abs(strain)) << name << column;
    EXPECT_NEAR(mean(table, name + ".stress_tt_pa", 4.2e-4, 4.5e-4), -2e7, 2e-3 * 2e7) << name;
    EXPECT_LT(mean(table, name + ".von_mises_pa", 4.2e-4, 4.5e-4), 0.02 * 2e7) << name;
  }
  EXPECT_NEAR(mean(table, "gauge.strain", 4.2e-4, 4.5e-4), strain, 2e-3 * std::abs(strain)) << "in two processes";
}

/// A bar that is pulled to 1 % and pushed back to 0.5 % yields once: E = 1 GPa, 4 MPa, H = 0.1 GPa.
TEST(Probe, OfABarThatYieldsTellsItsStressAndItsPlasticStrain) {
  const TemporaryFolder folder;
  const RunResult run = run_text(R"(model = "bar"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1e9, density_kg_m3 = 1000.0, plasticity = { yield_stress_pa = 4e6, hardening_pa = 1e8 } }
mesh = { length_m = 1.0, elements = 4 }
area_m2 = 1e-4
support = [{ surface = "start", fixed = ["x"] }]
prescribed = [{ surface = "end", component = "x", displacement_m = 0.01, amplitude = { time_s = [0.0, 0.5, 0.75, 1.0], factor = [0.0, 1.0, 0.5, 0.5] } }]
[time]
step_s = 2e-4
end_s = 0.75
[coupling]
protocol = "all_explicit"
[output]
probes_every = 25
[[output.probe]]
name = "p"
body = "rod"
at_m = [0.6]
[[output.gauge]]
name = "g"
body = "rod"
section_m = 0.5
length_m = 0.3
)",
                                 folder);
  const History table = probes(run);
  const double plastic = (0.01 * 1e9 - 4e6) / 1.1e9, stress_pa = 1e9 * (0.005 - plastic);
  EXPECT_NEAR(table.at("p.equivalent_plastic_strain").back(), plastic, 5e-3 * plastic);
  for (const char* column : {"p.stress_xx_pa", "g.stress_pa"})
    EXPECT_NEAR(table.at(column).back(), stress_pa, 0.01 * 4e6) << column;
  EXPECT_EQ(table.at("p.von_mises_pa").back(), std::abs(table.at("p.stress_xx_pa").back()));
  for (const char* column : {"p.strain_xx", "g.strain"}) EXPECT_NEAR(table.at(column).back(), 0.005, 1e-4) << column;
}

/// v_{n+1} - v_n = (a_n + a_{n+1}) / 2 dt, explicit, implicit, and from one to the other. Where the integration changes
/// a shared node has two accelerations: by the force that the link predicted, with which the window before ended, and
/// by that of the accepted displacement.
TEST(Probe, TellsTheAccelerationThatItsVelocityChangesBy) {
  const TemporaryFolder folder;
  std::string text = config_text("two_bars");
  text += "[output]\n";
  for (const auto& [name, x] : std::map<std::string, double>{{"out", -0.2}, {"shared", -0.0635}, {"in", -0.04}})
    text += fmt::format("[[output.probe]]\nname = \"{}\"\nbody = \"left\"\nat_m = [{}]\n", name, x);
  const RunResult run = run_text(text, folder);
  ASSERT_EQ(run.summary.at("switches").size(), 1U);
  const double switch_s = run.summary.at("switches")[0].at("time_s").get<double>();
  const History table = probes(run);
  const auto& time = table.at("time_s");
  for (const std::string name : {"out", "shared", "in"}) {
    const auto &v = table.at(name + ".velocity_x_m_s"), &a = table.at(name + ".acceleration_x_m_s2");
    for (std::size_t i = 1; i < time.size(); ++i) {
      const double dt = time[i] - time[i - 1];
      const double tolerance = name == "shared" && time[i - 1] == switch_s ? 1e-2 : 1e-10;
      EXPECT_NEAR(v[i] - v[i - 1], 0.5 * dt * (a[i] + a[i - 1]), tolerance * largest(a) * dt)
          << name << " in window " << i << (time[i] > switch_s ? ", after" : ", before") << " the switch at "
          << switch_s;
    }
  }
}

const std::string places = R"(
[[output.probe]]
name = "shared"
body = "steel"
at_m = [0.0025, -0.01]
[[output.gauge]]
name = "gauge"
body = "carbide"
section_m = 0.015
length_m = 0.004
rise_time_s = 1e-6
)";

TEST(Probe, TellsTheSameHoweverManyRanks) {
  const TemporaryFolder folder;
  const std::string text = replaced(config_text("kim_impact"), "end_s = 60e-6", "end_s = 6e-6") + places;
  const std::string implicit = "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  const std::string outside =
      "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"steel\", "
      "\"carbide\"]\n";
  const RunResult one = run_text(text + outside + implicit, folder, "one");
  const RunResult two = run_text(text + outside + "ranks = 2\n" + implicit, folder, "two");
  EXPECT_EQ(file_text(one.folder + "/probes.csv"), file_text(two.folder + "/probes.csv"));
  EXPECT_EQ(file_text(one.folder + "/history.csv"), file_text(two.folder + "/history.csv"));
  for (const auto& [column, values] : probes(one)) {
    for (const double value : values) ASSERT_TRUE(std::isfinite(value)) << column;
  }
}

TEST(Probe, GoesOnToTheSameBytes) {
  const TemporaryFolder folder;
  const std::string text = with_key(replaced(config_text("kim_impact"), "end_s = 60e-6", "end_s = 20e-6") + places,
                                    "checkpoint", "every_windows", "150");
  const RunResult whole = run_text(text, folder);
  (void)expect_the_same_from_the_earlier_checkpoint(whole, folder);
  EXPECT_TRUE(file_text(whole.folder + "_half/probes.csv") == file_text(whole.folder + "/probes.csv"));
}

TEST(Probe, IsWrittenOnlyIfItIsAskedFor) {
  const TemporaryFolder folder;
  const RunResult run = run_text(config_text("two_bars"), folder);
  EXPECT_FALSE(std::filesystem::exists(run.folder + "/probes.csv"));
  const RunResult never =
      run_text(config_text("two_bars") +
                   "[output]\nprobes_every = 0\n[[output.probe]]\nname = \"p\"\nbody = \"left\"\nat_m = [-0.1]\n",
               folder, "never");
  EXPECT_FALSE(std::filesystem::exists(never.folder + "/probes.csv"));
}

TEST(Probe, RowsMayComeByTime) {
  const TemporaryFolder folder;
  const std::string probe = "[[output.probe]]\nname = \"p\"\nbody = \"left\"\nat_m = [-0.1]\n";
  const RunResult run =
      run_text(config_text("two_bars") + "[output]\nhistory_every_s = 6.8e-6\nfields_every_s = 5e-5\n" + probe, folder);
  EXPECT_NEAR(run.column("time_s")[1], 3 * 2.226e-6, 1e-18);
  EXPECT_EQ(probes(run).at("time_s").size(), run.summary.at("windows").get<std::size_t>() + 1);
  EXPECT_TRUE(std::filesystem::exists(run.folder + "/fields/implicit.left_00000022.vtu"));
}

/// A wrong key is refused by name.
TEST(Probe, NamesWhatIsWrong) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& output, const std::string& expected) {
    const RunResult run = run_file(folder.write(config_text("two_bars") + "[output]\n" + output), folder);
    EXPECT_EQ(run.outcome.code, 2);
    EXPECT_THAT(run.outcome.error, HasSubstr(expected)) << output;
  };
  const std::string probe = "[[output.probe]]\nname = \"p\"\nbody = \"left\"\nat_m = [-0.1]\n";
  const std::string gauge = "[[output.gauge]]\nname = \"g\"\nbody = \"left\"\nsection_m = -0.1\n";
  refused(
      replaced(probe, "-0.1", "0.1"),
      "output.probe.p.at_m: found the place (0.1, 0) m, where body \"left\" has no element; allowed: a place in the "
      "body, which lies between (-0.254, 0) m and (0, 0) m");
  refused(
      replaced(gauge, "-0.1", "0.1"),
      "output.gauge.g.section_m: found 0.1 m, where body \"left\" has no element; allowed: a coordinate of its axis "
      "from -0.254 to 0 m");
  refused(probe + probe, "name: found \"p\" a second time; allowed: a name that no other probe or gauge has");
  refused(replaced(probe, "left", "lift"), "did you mean \"left\"?");
  refused(gauge + "surface = \"outer\"\n", "surface: found \"outer\"; allowed: only with a model of two or three");
  refused("probes_every = -1\n" + probe, "an integer from 0");
  refused("history_every = 2\nhistory_every_s = 1e-6\n", "both history_every and history_every_s");
  refused("probes_every_s = 1e-6\n", "only with an [[output.probe]] or an [[output.gauge]]");
}

}  // namespace
}  // namespace ricochet::test
