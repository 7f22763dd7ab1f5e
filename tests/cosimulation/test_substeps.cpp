// Windows that are too long for their substeps, in three dimensions: how wrong an impact gets, and what the run says.
// Prints the table of docs/limits.md.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two blocks of steel that meet end to end at 10 m/s, an implicit layer of two elements in each.
std::string steel_blocks(int substeps) {
  const auto block = [](const std::string& name, const std::string& start_m, const std::string& velocity) {
    return "[[body]]\nname = \"" + name +
           "\"\nmaterial = { youngs_modulus_pa = 206.8e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }\nmesh = { "
           "start_m = " +
           start_m + ", length_m = 0.05, height_m = 0.01, width_m = 0.01, elements = [4, 4, 20] }\n" +
           "initial_velocity_m_s = [0.0, 0.0, " + velocity + "]\n";
  };
  std::string text = "model = \"solid\"\n" + block("a", "-0.05", "10.0") + block("b", "0.0", "0.0") +
                     "[contact]\nsurfaces = [\"a.end\", \"b.start\"]\n"
                     "[partition]\nimplicit_length_m = { a = 0.005, b = 0.005 }\n"
                     "[time]\nsafety_factor = 0.9\nend_s = 60e-6\n[coupling]\nprotocol = \"prakash_hjelmstad\"\n";
  return substeps == 1 ? text : text + fmt::format("substeps = {}\n", substeps);
}

TEST(Substeps, ThatAreTooManyAreWarnedOfByWhatTheInterfaceMakesOfTheEnergy) {
  const TemporaryFolder folder;
  double exact_n_s = 0.0, exact_m_s = 0.0, exact_kept_m_s = 0.0;
  std::printf("%-8s %14s %14s %14s %14s\n", "substeps", "impulse", "rebound", "striker keeps", "interface");
  for (const int m : {1, 2, 4, 8}) {
    const auto run = run_text(steel_blocks(m), folder, "m" + std::to_string(m));
    const double impulse_n_s = run.summary.at("contact_impulse_n_s"), rebound_m_s = run.last("velocity_mean_b_m_s"),
                 kept_m_s = run.last("velocity_mean_a_m_s");
    const double share = run.summary.at("interface_energy_max");
    if (m == 1) exact_n_s = impulse_n_s, exact_m_s = rebound_m_s, exact_kept_m_s = kept_m_s;
    const double error = std::abs(rebound_m_s / exact_m_s - 1.0);
    const double of_impulse = impulse_n_s / exact_n_s - 1.0, of_kept = kept_m_s / exact_kept_m_s - 1.0;
    std::printf("%-8d %+13.2f%% %+13.2f%% %+13.2f%% %13.2f%%\n", m, 100.0 * of_impulse,
                100.0 * (rebound_m_s / exact_m_s - 1.0), 100.0 * of_kept, 100.0 * share);
    // M v = M V - J: as much of M V - M v as of J.
    EXPECT_NEAR(of_kept, -of_impulse * (10.0 - exact_kept_m_s) / exact_kept_m_s, 1e-8) << m;
    EXPECT_LT(error, 0.8 * share + 0.002) << m;
    const auto warned = HasSubstr("windows of " + std::to_string(m) + " substeps are too long");
    if (m >= 4) {
      EXPECT_THAT(run.outcome.error, warned);
      EXPECT_THAT(run.outcome.out, warned);
    } else {
      EXPECT_THAT(run.outcome.error, Not(HasSubstr("substeps are too long")));
    }
  }
}

/// In a round contact, whose force rises over many windows, as many substeps are no trouble.
TEST(Substeps, ThatARoundContactBearsAreNot) {
  const TemporaryFolder folder;
  std::string text = with_protocol(with_absolute_meshes(config_text("two_balls_solid")), "prakash_hjelmstad");
  text = with_key(replaced(text, "step_s = 5e-8", "step_s = 2e-7"), "coupling", "substeps", "4");
  const auto run = run_text(text, folder);
  EXPECT_LT(run.summary.at("interface_energy_max").get<double>(), 2e-3);
  EXPECT_THAT(run.outcome.error, Not(HasSubstr("substeps are too long")));
}

}  // namespace
}  // namespace ricochet::test
