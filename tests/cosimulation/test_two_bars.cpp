#include "tests/support/run.hpp"

// Acceptance A1, configs/two_bars.toml: two equal bars meet head on. Exact: t_imp = 49.456 us, release t_imp + 2L/c =
// 148.393 us, force Z v0 between, kinetic energy 1 - s c/L, then s c/L - 1, full rebound.

namespace ricochet::test {
namespace {

constexpr double impact_s = 49.456e-6, release_s = 148.393e-6, length_m = 0.254, force_n = 1.33453e5, v0 = 5.13588;
constexpr double window_s = 2.226e-6;
constexpr int elements = 20;

class TwoBars : public testing::TestWithParam<const char*> {
 protected:
  TwoBars() : run_(run_text(with_protocol(config_text("two_bars"), GetParam()), folder_)) {}
  TemporaryFolder folder_;
  RunResult run_;
};

TEST_P(TwoBars, SeparateWithinTwoWindowsOfTheExactRelease) {
  EXPECT_NEAR(run_.summary.at("separation_time_s").get<double>(), release_s, 2.0 * window_s);
  EXPECT_EQ(run_.summary.at("status"), "done");
}

TEST_P(TwoBars, PressEachOtherWithImpedanceTimesVelocity) {
  EXPECT_NEAR(run_.mean("contact_force_n", 60e-6, 140e-6), force_n, 0.01 * force_n);
  EXPECT_NEAR(run_.mean("principal_stress_mean_pa", 60e-6, 140e-6), force_n / 6.4516e-4, 0.01 * force_n / 6.4516e-4);
  EXPECT_EQ(run_.mean("contact_force_n", 0.0, impact_s - window_s), 0.0);
}

TEST_P(TwoBars, TurnKineticIntoStrainEnergyAndBack) {
  const auto& time = run_.column("time_s");
  const auto& kinetic = run_.column("energy_kinetic_j");
  const double c = std::sqrt(206.8e9 / 7844.066);
  double error = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    const double s = (time[i] - impact_s) * c / length_m;
    if (s < 0.1 || s > 1.9) continue;
    const double exact = s < 1.0 ? 1.0 - s : s - 1.0;
    error += std::pow(kinetic[i] / kinetic[0] - exact, 2);
    ++count;
  }
  EXPECT_LT(std::sqrt(error / count), 0.05);
  EXPECT_GT(count, 30);
}

TEST_P(TwoBars, ReboundAndLoseNoMoreThanTheContactNodesEnergyAtEachImpact) {
  // 1/(2n) = 2.5 % at the impact; the chatter at release may cost it a second time, at most.
  EXPECT_GE(run_.smallest("energy_error"), -2.0 / (2 * elements));
  EXPECT_LE(run_.largest("energy_error"), 5e-4);
  EXPECT_LE(run_.last("energy_error"), -0.9 / (2 * elements));
  if (std::string(GetParam()) == "hughes_liu") {
    EXPECT_NEAR(run_.last("energy_error"), -0.028, 0.0028);
  }
  if (std::string(GetParam()) == "all_implicit") {
    EXPECT_NEAR(run_.last("energy_error"), -0.031, 0.0031);
  }
  const double kept = std::sqrt(1.0 + run_.last("energy_error"));
  EXPECT_NEAR(run_.last("velocity_mean_left_m_s"), -v0 * kept, 0.05 * v0) << "some energy stays as vibration";
  EXPECT_NEAR(run_.last("velocity_mean_right_m_s"), v0 * kept, 0.05 * v0);
}

TEST_P(TwoBars, KeepTheirMomentum) { EXPECT_LT(run_.summary.at("momentum_error_max").get<double>(), 1e-12); }

/// Protocol and largest energy error on the way. `hughes_liu` conserves its own measure of energy at the interface,
/// which is not kinetic + strain: with waves as short as those of an impact on 20 elements the two differ by 1.2 %.
class TwoBarsMassless : public testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(TwoBarsMassless, KeepTheirEnergyAndEveryJouleHasAnOwner) {
  const auto& [protocol, largest] = GetParam();
  const TemporaryFolder folder;
  const RunResult run = run_text(
      with_key(with_protocol(config_text("two_bars"), protocol), "contact", "multiplier_update", "\"massless\""),
      folder);
  const double first = run.column("energy_kinetic_j").front();
  EXPECT_GT(run.smallest("energy_error"), -largest);
  EXPECT_LT(run.largest("energy_error"), largest);
  EXPECT_LT(std::abs(run.last("energy_contact_j")), 1e-6 * first) << "closing and opening cost nothing";
  EXPECT_NEAR(run.mean("contact_force_n", 60e-6, 140e-6), force_n, 0.01 * force_n);
  EXPECT_NEAR(run.summary.at("separation_time_s").get<double>(), release_s, 2.0 * window_s);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  const auto& switches = run.summary.at("switches");
  const double switched_s = switches.empty() ? 1.0 : switches[0].at("time_s").get<double>();
  double drift = 0.0;
  for (std::size_t i = 0; i < run.column("time_s").size() && run.column("time_s")[i] <= switched_s; ++i) {
    const auto value = [&](const char* term) { return run.column(std::string("energy_") + term + "_j")[i]; };
    drift = std::max(drift, std::abs(value("kinetic") + value("strain") - value("external") - value("contact") -
                                     value("interface") - first));
  }
  EXPECT_LT(drift, 1e-12 * first);
}

INSTANTIATE_TEST_SUITE_P(Protocols, TwoBarsMassless,
                         testing::Values(std::pair("hughes_liu", 0.0125), std::pair("belytschko_mullen", 1e-6),
                                         std::pair("all_implicit", 1e-6), std::pair("all_explicit", 1e-6)),
                         [](const auto& test) { return std::string(test.param.first); });

TEST(TwoBarsMasslessHybrid, IntegratesItsMasslessNodesExplicitlyAfterTheSwitch) {
  const TemporaryFolder folder;
  const RunResult run =
      run_text(with_key(config_text("two_bars"), "contact", "multiplier_update", "\"massless\""), folder);
  ASSERT_EQ(run.summary.at("switches").size(), 1U);
  const double switched_s = run.summary.at("switches")[0].at("time_s").get<double>();
  double lowest = 1.0, highest = -1.0;
  for (std::size_t i = 0; i < run.column("time_s").size(); ++i) {
    if (run.column("time_s")[i] <= switched_s + 0.5 * window_s) continue;
    lowest = std::min(lowest, run.column("energy_error")[i]);
    highest = std::max(highest, run.column("energy_error")[i]);
  }
  EXPECT_LT(highest - lowest, 1e-10) << "the staggered energy of central difference";
}

INSTANTIATE_TEST_SUITE_P(Protocols, TwoBars, testing::Values("hughes_liu", "kim", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace ricochet::test
