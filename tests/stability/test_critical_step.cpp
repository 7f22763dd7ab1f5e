#include <gmock/gmock.h>

#include <algorithm>

#include "tests/stability/edges.hpp"

// docs/limits.md, 8 and 9: steps near the critical one, and stiff implicit neighbours of explicit elements.

namespace ricochet::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Rod on a stop (A2) for twenty impacts.
std::string long_rod(const std::string& protocol, double safety_factor) {
  const std::string text = replaced(small_rod_on_stop(), "end_s = 12.0", "end_s = 60.0");
  return with_protocol(replaced(text, "safety_factor = 0.9", "safety_factor = " + number(safety_factor)), protocol);
}

// Row 8. At Courant 1 the shortest wave's frequency is 2/dt: it grows linearly. Its energy in the conserved metric is
// zero, so that only the strain energy shows it.
TEST(CourantOne, TheShortestWaveGrowsInAllExplicit) {
  const TemporaryFolder folder;
  const auto strain = [&](double safety_factor) {
    const std::string text =
        with_key(long_rod("all_explicit", safety_factor), "coupling", "energy_growth_limit", "1e9");
    return run_text(text, folder).largest("energy_strain_j");
  };
  EXPECT_LT(strain(0.999), 1.1 * 0.125e-6);
  EXPECT_GT(strain(1.0), 1e3 * 0.125e-6) << "measured: 1047 uJ of the rod's 0.125 uJ";
  EXPECT_THAT(check_text(long_rod("all_explicit", 1.0), folder).out, HasSubstr("may grow from impact to impact"));
  EXPECT_THAT(check_text(long_rod("all_explicit", 0.999), folder).out, Not(HasSubstr("warning")));
}

TEST(CourantOne, AHybridGainsEnergyEarlier) {
  const TemporaryFolder folder;
  const double edge =
      measured_edge(0.9, 0.995, [&](double factor) { return grows(long_rod("hughes_liu", factor), folder); });
  EXPECT_NEAR(edge, 0.972, 0.01) << "check warns from 0.95 on";
  EXPECT_THAT(check_text(long_rod("hughes_liu", 0.955), folder).out, HasSubstr("may grow from impact to impact"));
  EXPECT_THAT(check_text(long_rod("hughes_liu", 0.945), folder).out, Not(HasSubstr("warning")));
  const RunResult run = run_file(folder.write(long_rod("hughes_liu", 0.9995)), folder);
  EXPECT_EQ(run.outcome.code, 3);
  EXPECT_THAT(run.outcome.error, HasSubstr("the time step is 0.9995 times the critical step"));
}

/// A bar of 20 explicit elements of 50 mm and one implicit element at its end, `ratio` times stiffer (and shorter).
std::string stiff_tip_mesh(double ratio) {
  std::ostringstream text;
  text.precision(17);
  text << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n0 3 \"tip_end\"\n1 1 \"bar\"\n1 2 "
          "\"tip\"\n$EndPhysicalNames\n"
       << "$Entities\n1 2 0 0\n1 " << 1.0 + 0.05 / ratio << " 0 0 1 3\n1 0 0 0 1 0 0 1 1 0\n2 1 0 0 "
       << 1.0 + 0.05 / ratio << " 0 0 2 1 2 0\n$EndEntities\n$Nodes\n1 22 1 22\n1 1 0 22\n";
  for (int i = 1; i <= 22; ++i) text << i << "\n";
  for (int i = 0; i <= 20; ++i) text << 0.05 * i << " 0 0\n";
  text << 1.0 + 0.05 / ratio << " 0 0\n$EndNodes\n$Elements\n3 22 1 22\n0 1 15 1\n1 22\n1 1 1 20\n";
  for (int i = 1; i <= 20; ++i) text << i + 1 << " " << i << " " << i + 1 << "\n";
  text << "1 2 1 1\n22 21 22\n$EndElements\n";
  return text.str();
}

std::string stiff_tip(const std::string& protocol, double step_s) {
  return "model = \"bar\"\n[[body]]\nname = \"bar\"\nmaterial = { youngs_modulus_pa = 1e9, density_kg_m3 = 1000.0 }\n"
         "mesh = { gmsh = \"tip.msh\" }\ninitial_displacement_m = { start = [-1e-3], end = [1e-3] }\n"
         "[contact]\nsurfaces = [\"bar.tip_end\", \"rigid_plane\"]\ninitial_gap_m = 1.0\n"
         "[partition]\nimplicit_groups = { bar = [\"tip\"] }\n[time]\nstep_s = " +
         number(step_s) +
         "\nend_s = 0.1\n"
         "[coupling]\nprotocol = \"" +
         protocol + "\"\n";
}

// Row 9. Integrated explicitly with stiffness k ratio on the mass m of a bar's node, the shared node would allow
// 2 sqrt(m / (k ratio)), 0.020 of h / c at ratio 1e4. Shared nodes are implicit, so nothing of that shows.
TEST(StiffImplicitNeighbour, DoesNotLowerTheStepOfTheExplicitElements) {
  const double courant_s = 0.05 / 1000.0;
  for (const double ratio : {1.0, 100.0, 1e4}) {
    const TemporaryFolder folder;
    (void)folder.write(stiff_tip_mesh(ratio), "tip.msh");
    const double edge = measured_edge(
        0.9, 1.1, [&](double share) { return refused(stiff_tip("hughes_liu", share * courant_s), folder); });
    EXPECT_NEAR(edge, 1.0, 0.01) << ratio;
    // The sum of two metrics of energy sways, the more the closer to Courant 1, but it does not grow.
    const RunResult run =
        run_text(with_key(stiff_tip("hughes_liu", 0.96 * courant_s), "coupling", "energy_growth_limit", "1e9"), folder);
    const auto& error = run.column("energy_error");
    ASSERT_GT(error.size(), 2000U);
    const auto middle = error.begin() + static_cast<std::ptrdiff_t>(error.size() / 2);
    EXPECT_LT(*std::max_element(middle, error.end()), 1.1 * *std::max_element(error.begin(), middle)) << ratio;
    EXPECT_LT(run.largest("energy_error"), 0.2) << ratio;
    EXPECT_GT(run.smallest("energy_error"), -0.01) << ratio;
    EXPECT_EQ(refused(stiff_tip("all_explicit", 0.020 * courant_s), folder), ratio > 1.0) << ratio;
  }
}

// Row 2 without a penalty: in contact, a layer much stiffer than what is behind it is one to its inner node.
TEST(StiffContactLayer, MakesEnergyLikeAPenalty) {
  for (const auto& [protocol, expected] : {std::pair{"hughes_liu", 1.05}, std::pair{"all_implicit", 1.18}}) {
    for (const double ratio : {1.0, 100.0}) {
      const TemporaryFolder folder;
      (void)folder.write(stiff_tip_mesh(ratio), "tip.msh");
      std::string text =
          replaced(stiff_tip(protocol, 0.8 * 0.05 / 1000.0), "initial_gap_m = 1.0", "initial_gap_m = 0.1");
      text =
          replaced(text, "initial_displacement_m = { start = [-1e-3], end = [1e-3] }", "initial_velocity_m_s = [20.0]");
      const double growth = unwatched_growth(text, folder);
      if (ratio > 1.0) {
        EXPECT_NEAR(growth, expected, 0.1 * expected) << protocol;
      }
      if (ratio == 1.0) {
        EXPECT_LT(growth, 0.01) << protocol;
      }
    }
  }
}

}  // namespace
}  // namespace ricochet::test
