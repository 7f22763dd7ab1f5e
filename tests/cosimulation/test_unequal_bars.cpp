#include "tests/support/run.hpp"

// Acceptance A4: striker (Z1, L1) on a long bar (Z2): F_n = v Z1 Z2/(Z1+Z2) r^n in the n-th interval of 2 L1/c1, with
// r = (Z1-Z2)/(Z1+Z2); for Z1 <= Z2 they separate after the first.

namespace ricochet::test {
namespace {

constexpr double area = 1e-4;
const double z_steel = area * std::sqrt(207e9 * 7860), z_aluminium = area * std::sqrt(70e9 * 2700);
const double interval_s = 2 * 0.1 / std::sqrt(207e9 / 7860);

class UnequalBars : public testing::TestWithParam<const char*> {};

TEST_P(UnequalBars, ForceFallsInStepsIfTheStrikerIsStiffer) {
  const TemporaryFolder folder;
  const RunResult run = run_text(with_protocol(config_text("unequal_bars"), GetParam()), folder);
  const double first = 10.0 * z_steel * z_aluminium / (z_steel + z_aluminium),
               r = (z_steel - z_aluminium) / (z_steel + z_aluminium);
  for (int n = 0; n < 3; ++n) {
    const double mean = run.mean("contact_force_n", (n + 0.2) * interval_s, (n + 0.8) * interval_s);
    EXPECT_NEAR(mean, first * std::pow(r, n), 0.01 * first) << "interval " << n;
  }
}

TEST_P(UnequalBars, TheyPartAfterOneIntervalIfTheStrikerIsSofter) {
  const TemporaryFolder folder;
  // The striker made of the bar's aluminium, the bar of the striker's steel: Z1 < Z2.
  std::string text = config_text("unequal_bars");
  text = replaced(text, "youngs_modulus_pa = 207e9, density_kg_m3 = 7860.0",
                  "youngs_modulus_pa = 70e9, density_kg_m3 = 2701.0");
  text = replaced(text, "youngs_modulus_pa = 70e9, density_kg_m3 = 2700.0",
                  "youngs_modulus_pa = 207e9, density_kg_m3 = 7860.0");
  const RunResult run = run_text(with_protocol(text, GetParam()), folder);
  const double transit_s = 2 * 0.1 / std::sqrt(70e9 / 2701.0);
  EXPECT_NEAR(run.summary.at("separation_time_s").get<double>(), transit_s, 0.03 * transit_s);
  EXPECT_EQ(run.mean("contact_force_n", 1.2 * transit_s, 116e-6), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Protocols, UnequalBars, testing::Values("hughes_liu", "kim", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// The striker of steel, the bar a thousand times as soft, of as many and as long elements; a window of 14.2 transit
/// times of the striker's elements, 0.45 of the bar's.
std::string thousand_to_one(const std::string& law, double step_s = 2.774e-6) {
  std::string text =
      replaced(with_protocol(config_text("unequal_bars"), "all_implicit"),
               "youngs_modulus_pa = 70e9, density_kg_m3 = 2700.0", "youngs_modulus_pa = 207e6, density_kg_m3 = 7860.0");
  text = replaced(text, "length_m = 0.4, elements = 400", "length_m = 0.1, elements = 100");
  text = replaced(text, "[contact]", "[contact]\nmultiplier_update = \"" + law + "\"");
  text = with_key(with_key(text, "time", "end_s", "1.2e-3"), "coupling", "energy_growth_limit", "1.0");
  return replaced(text, "safety_factor = 0.9", "step_s = " + std::to_string(1e6 * step_s) + "e-6");
}

TEST(UnequalBodies, AreSoundByEveryLawThatIsNotRefused) {
  const TemporaryFolder folder;
  EXPECT_LT(run_text(thousand_to_one("massless"), folder).largest("energy_error"), 1e-6);
  EXPECT_LT(run_text(thousand_to_one("fully_implicit"), folder).largest("energy_error"), 1e-12);
  EXPECT_LT(run_text(thousand_to_one("trapezoidal_reset", 0.97e-6), folder).largest("energy_error"), 5e-3)
      << "4.98 transit times";
}

TEST(UnequalBodies, AreRefusedByTheResetLawWithTheLawToTake) {
  const TemporaryFolder folder;
  const RunResult run = run_file(folder.write(thousand_to_one("trapezoidal_reset")), folder);
  EXPECT_EQ(run.outcome.code, 2);
  for (const char* said : {"2.77e-06 s", "14.2 times", "\"striker\"", "0.45 times", "\"bar\"", "time.step_s = 9.74e-07",
                           "contact.multiplier_update = \"massless\"", "\"fully_implicit\""})
    EXPECT_NE(run.outcome.error.find(said), std::string::npos) << said << " in: " << run.outcome.error;
}

}  // namespace
}  // namespace ricochet::test
