#include <gmock/gmock.h>

#include <iomanip>
#include <regex>

#include "tests/support/run.hpp"

// Dual and iterated protocols through scene files and three real processes.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

/// A bar of 1 m^2 with elements of the given number along [0, length]; the first `implicit` of them are the group
/// "left".
std::string bar_mesh(int elements, int implicit, double length) {
  std::ostringstream msh;
  msh << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n0 1 \"start\"\n0 2 \"end\"\n1 3 \"rod\"\n1 4 "
         "\"left\"\n$EndPhysicalNames\n"
      << "$Entities\n2 2 0 0\n1 0 0 0 1 1\n2 " << length << " 0 0 1 2\n1 0 0 0 " << length
      << " 0 0 2 3 4 2 1 -2\n2 0 0 0 " << length << " 0 0 1 3 2 1 -2\n$EndEntities\n$Nodes\n1 " << elements + 1 << " 1 "
      << elements + 1 << "\n1 1 0 " << elements + 1 << "\n";
  for (int i = 0; i <= elements; ++i) msh << i + 1 << "\n";
  for (int i = 0; i <= elements; ++i) msh << length * i / elements << " 0 0\n";
  msh << "$EndNodes\n$Elements\n4 " << elements + 2 << " 1 " << elements + 2 << "\n0 1 15 1\n1 1\n0 2 15 1\n2 "
      << elements + 1 << "\n";
  for (const int curve : {1, 2}) {
    const int first = curve == 1 ? 0 : implicit, last = curve == 1 ? implicit : elements;
    msh << "1 " << curve << " 1 " << last - first << "\n";
    for (int e = first; e < last; ++e) msh << e + 3 << " " << e + 1 << " " << e + 2 << "\n";
  }
  msh << "$EndElements\n";
  return msh.str();
}

std::string number(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

std::string coupling(const std::string& protocol, int substeps = 0) {
  return "[coupling]\noutside_model = \"go_on\"\nprotocol = \"" + protocol + "\"\n" +
         (substeps > 0 ? "substeps = " + std::to_string(substeps) + "\n" : "");
}

/// Acceptance scene A7: two masses of 1 kg tied together, a spring of (2 pi)^2 N/m from each to the ground; one side
/// trapezoidal, one central difference. A constant body force that starts at t = 0 swings them by 1 m about their rest.
struct SplitOscillator {
  static constexpr double stiffness = 4 * M_PI * M_PI;

  static RunResult run(const TemporaryFolder& folder, const std::string& protocol, int substeps, double window,
                       double periods = 10) {
    (void)folder.write(bar_mesh(2, 1, 20.0),
                       "split.msh");  // long: a swing of 1 m, and another, is to invert no element
    const std::string text =
        "model = \"bar\"\n[[body]]\nname = \"rod\"\nmesh = { gmsh = \"split.msh\" }\n"
        "material = { youngs_modulus_pa = " +
        number(10 * stiffness) +
        ", density_kg_m3 = 0.2 }\n"
        "support = [{ surface = \"start\", fixed = [\"x\"] }, { surface = \"end\", fixed = [\"x\"] }]\n"
        "gravity_m_s2 = [" +
        number(stiffness) +
        "]\n[partition]\nimplicit_groups = { rod = [\"left\"] }\n"
        "[time]\nstep_s = " +
        number(window) + "\nend_s = " + number(periods) + "\n" + coupling(protocol, substeps);
    return run_text(text, folder, protocol + std::to_string(substeps) + "_" + number(window));
  }
  /// Change of kinetic + strain - external energy over that of the swing about rest, 1/2 (2 k) (1 m)^2. The kinetic
  /// energy is that of the common velocity; history.csv has the explicit side's in the staggered metric.
  static double energy_change(const RunResult& run) {
    const double momentum = run.last("momentum_n_kg_m_s"), mass = 2.0;
    return (momentum * momentum / (2 * mass) + run.last("energy_strain_j") - run.last("energy_external_j")) / stiffness;
  }
};

TEST(SplitOscillator, LosesWhatTheAcceptanceTableSays) {
  const TemporaryFolder folder;
  const double windows[] = {0.05, 0.025, 0.0125}, pseudo[] = {-1.5e-4, -2.5e-6, -3.8e-8},
               dissipated[] = {-0.712, -0.461, -0.266};
  for (int i = 0; i < 3; ++i) {
    const auto ph = SplitOscillator::run(folder, "prakash_hjelmstad", 2, windows[i]);
    EXPECT_NEAR(SplitOscillator::energy_change(ph), pseudo[i], 0.04 * std::abs(pseudo[i])) << windows[i];
    const auto gc = SplitOscillator::run(folder, "gravouil_combescure", 2, windows[i]);
    EXPECT_NEAR(SplitOscillator::energy_change(gc), dissipated[i], 2e-3) << windows[i];
  }
}

/// The interface is the only place where a dual protocol can make or lose energy: either side conserves its own.
TEST(SplitOscillator, EveryJouleIsTheInterfaces) {
  const TemporaryFolder folder;
  for (const char* protocol : {"prakash_hjelmstad", "gravouil_combescure"}) {
    for (const int m : {1, 2, 5}) {
      const auto run = SplitOscillator::run(folder, protocol, m, 0.05);
      double largest = 0.0;
      for (std::size_t i = 0; i < run.column("time_s").size(); ++i) {
        const double energy = run.column("energy_kinetic_j")[i] + run.column("energy_strain_j")[i] -
                              run.column("energy_external_j")[i] - run.column("energy_interface_j")[i];
        const double start = run.column("energy_kinetic_j")[0];
        largest = std::max(largest, std::abs(energy - start));
      }
      EXPECT_LT(largest, 1e-10 * SplitOscillator::stiffness) << protocol << " " << m;
      const auto& work = run.column("energy_interface_j");
      if (m > 1 && std::string(protocol) == "gravouil_combescure") {
        EXPECT_LT(work.back(), -0.3 * SplitOscillator::stiffness) << "dissipates";
        EXPECT_LT(*std::max_element(work.begin(), work.end()), 0.01 * SplitOscillator::stiffness) << "and makes none";
      } else {
        EXPECT_LT(std::abs(work.back()), 2e-2 * SplitOscillator::stiffness)
            << "neither makes nor loses any in the long run";
      }
    }
  }
}

TEST(DualProtocols, WithOneSubstepAreHughesLiu) {
  const TemporaryFolder folder;
  for (const char* config : {"two_bars", "kim_impact"}) {
    const std::string text = with_key(with_key(with_key(config_text(config), "output", "fields_every", "0"), "coupling",
                                               "after_separation", "\"implicit\""),
                                      "time", "end_s", "40e-6");
    const RunResult hl = run_text(text, folder, "hl");
    for (const char* protocol : {"prakash_hjelmstad", "gravouil_combescure"}) {
      const RunResult dual = run_text(with_protocol(text, protocol), folder, protocol);
      double difference = 0.0;
      for (std::size_t i = 0; i < hl.column("time_s").size(); ++i) {
        difference =
            std::max(difference, std::abs(hl.column("contact_force_n")[i] - dual.column("contact_force_n")[i]));
      }
      EXPECT_LE(difference, 1e-10 * hl.largest("contact_force_n")) << config << " " << protocol;
    }
  }
}

std::string impact(const std::string& protocol, int substeps) {
  std::string text = with_key(config_text("kim_impact"), "output", "fields_every", "0");
  text = with_key(text, "time", "step_s", number(5.4e-8 * std::max(1, substeps)));
  text = with_protocol(text, protocol);
  return substeps > 0 ? with_key(text, "coupling", "substeps", std::to_string(substeps)) : text;
}

TEST(PrakashHjelmstad, ComputesThePapersImpactWithFrictionInLongerWindows) {
  const TemporaryFolder folder;
  for (const int m : {2, 4, 6}) {
    const RunResult run = run_text(impact("prakash_hjelmstad", m), folder, std::to_string(m));
    EXPECT_NEAR(run.mean("contact_pressure_mean_pa", 5e-6, 20e-6), 853.8e6, 0.005 * 853.8e6) << m;
    EXPECT_LT(run.largest("energy_error"), 0.01) << m;
    EXPECT_GT(run.smallest("energy_error"), -0.01) << m;
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10) << m;
    EXPECT_NEAR(run.last("velocity_mean_steel_m_s"), -6.47, 0.05) << m;
    EXPECT_NEAR(run.last("velocity_mean_carbide_m_s"), 19.24, 0.05) << m;
    EXPECT_NEAR(run.summary.at("separation_time_s").get<double>(), 31.0e-6, 0.5e-6) << m;
    EXPECT_THAT(run.summary.at("notes").dump(),
                HasSubstr("stays implicit after separation: protocol prakash_hjelmstad"));
  }
}

TEST(PrakashHjelmstad, TwoExplicitProcessesGiveTheSameAsOne) {
  const TemporaryFolder folder;
  const std::string one = impact("prakash_hjelmstad", 3);
  const std::string two =
      one +
      "[[participant]]\nname = \"a\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n[[participant]]\nname = \"b\"\nrole = "
      "\"explicit\"\nbodies = [\"carbide\"]\n[[participant]]\nname = \"i\"\nrole = \"implicit\"\n";
  const RunResult single = run_text(with_key(one, "time", "end_s", "10e-6"), folder, "one");
  const RunResult twice = run_text(with_key(two, "time", "end_s", "10e-6"), folder, "two");
  for (const char* column : {"contact_force_n", "energy_kinetic_j", "energy_strain_j"}) {
    const double scale = single.largest(column);
    for (std::size_t i = 0; i < single.column(column).size(); ++i) {
      EXPECT_NEAR(single.column(column)[i], twice.column(column)[i], 1e-10 * scale) << column << " row " << i;
    }
  }
}

/// A smooth, loaded rod; the histories of its momentum in steps of T/64.
std::vector<double> momentum(const TemporaryFolder& folder, const std::string& protocol, int substeps, int windows) {
  (void)folder.write(bar_mesh(8, 4, 1.0), "rod.msh");
  const std::string text =
      "model = \"bar\"\n[[body]]\nname = \"rod\"\nmesh = { gmsh = \"rod.msh\" }\n"
      "material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }\nsupport = [{ surface = \"start\", fixed = [\"x\"] "
      "}]\n"
      "traction = [{ surface = \"end\", traction_pa = [0.3], amplitude = { time_s = [0.0, 0.5], factor = [0.0, 1.0] } "
      "}]\n"
      "gravity_m_s2 = [0.2]\n[partition]\nimplicit_groups = { rod = [\"left\"] }\n[time]\nstep_s = " +
      number(2.0 / windows) + "\nend_s = 2.0\n" + coupling(protocol, substeps);
  const RunResult run = run_text(text, folder, protocol + std::to_string(substeps) + "_" + std::to_string(windows));
  const auto& all = run.column("momentum_n_kg_m_s");
  std::vector<double> sampled;
  for (int i = 1; i <= 64; ++i) sampled.push_back(all.at(static_cast<std::size_t>(i * windows / 64)));
  return sampled;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

struct Order {
  const char* protocol;
  int substeps;  ///< 0: not a dual protocol
  double expected;
};

class OrderInWindow : public testing::TestWithParam<Order> {};

TEST_P(OrderInWindow, IsMeasured) {
  const auto& [protocol, substeps, expected] = GetParam();
  const TemporaryFolder folder;
  const auto coarse = momentum(folder, protocol, substeps, 256), middle = momentum(folder, protocol, substeps, 512),
             fine = momentum(folder, protocol, substeps, 1024);
  EXPECT_NEAR(std::log2(difference(coarse, middle) / difference(middle, fine)), expected, 0.15);
  EXPECT_GT(difference(coarse, middle), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Protocols, OrderInWindow,
                         testing::Values(Order{"hughes_liu", 0, 2.0}, Order{"kim", 0, 2.0},
                                         Order{"belytschko_mullen", 0, 2.0}, Order{"fixed_point", 0, 2.0},
                                         Order{"prakash_hjelmstad", 1, 2.0}, Order{"prakash_hjelmstad", 4, 2.0},
                                         Order{"gravouil_combescure", 1, 2.0}, Order{"gravouil_combescure", 4, 1.0}),
                         [](const auto& test) {
                           return test.param.protocol + std::string("_") + std::to_string(test.param.substeps);
                         });

TEST(FixedPoint, ConvergesToBelytschkoMullenWithAnyAcceleration) {
  const TemporaryFolder folder;
  const std::string text = with_key(impact("belytschko_mullen", 0), "time", "end_s", "8e-6");
  const RunResult direct = run_text(text, folder, "direct");
  for (const char* acceleration : {"constant", "aitken", "iqn_ils"}) {
    const RunResult run = run_text(with_key(with_protocol(text, "fixed_point"), "coupling", "acceleration",
                                            std::string("\"") + acceleration + "\""),
                                   folder, acceleration);
    double largest = 0.0;
    for (std::size_t i = 0; i < run.column("time_s").size(); ++i) {
      largest = std::max(largest, std::abs(run.column("contact_force_n")[i] - direct.column("contact_force_n")[i]));
    }
    EXPECT_LT(largest, 1e-7 * direct.largest("contact_force_n")) << acceleration;
    const std::string notes = run.summary.at("notes").dump();
    std::smatch note;
    ASSERT_TRUE(
        std::regex_search(notes, note, std::regex("fixed_point: ([0-9.]+) iterations a window, at most ([0-9]+)")))
        << notes;
    EXPECT_GT(std::stod(note[1]), 3.0) << acceleration << ": one to see that it agrees, and some before";
    EXPECT_LE(std::stod(note[1]), std::stod(note[2])) << acceleration;
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-9) << acceleration;
  }
}

TEST(FixedPoint, ThatDoesNotConvergeEndsTheRunAndSaysWhatToType) {
  const TemporaryFolder folder;
  const std::string text = with_key(impact("fixed_point", 0), "coupling", "max_iterations", "2");
  const RunResult run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 3);
  EXPECT_THAT(run.outcome.error, HasSubstr("fixed_point has not converged"));
  EXPECT_THAT(run.outcome.error, HasSubstr("coupling.max_iterations = 2"));
}

TEST(DualProtocols, RefuseExplicitElementsAtTheContact) {
  const TemporaryFolder folder;
  const std::string text =
      with_key(impact("prakash_hjelmstad", 0), "partition", "implicit_length_m", "{ steel = 0.0, carbide = 0.015 }");
  const RunResult run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 2);
  EXPECT_THAT(run.outcome.error, HasSubstr("found \"prakash_hjelmstad\" and an explicit element at the contact node"));
}

}  // namespace
}  // namespace ricochet::test
