#include <gmock/gmock.h>

#include "tests/stability/edges.hpp"

// docs/limits.md, 1 to 5: penalties and the exact gap constraint under the trapezoidal rule and central
// differences.

namespace ricochet::test {
namespace {

using testing::HasSubstr;
using testing::Not;

// Two bars (A1): E A / h of an element, and its wave speed. Rod on a stop (A2): E = rho = A = L = 1, 100 elements.
constexpr double bars_k_pa_m = 206.8e9 / (0.254 / 20), rod_k_pa_m = 100.0, rod_element_m = 0.01;

std::string bars(const std::string& protocol) { return with_protocol(config_text("two_bars"), protocol); }
std::string rod(const std::string& protocol) { return with_protocol(small_rod_on_stop(), protocol); }

/// (h/c) sqrt(2 / (1 + sqrt(1 + (alpha/k)^2))): central difference, penalty against a rigid plane.
double explicit_penalty_limit_s(double alpha_over_k) {
  return rod_element_m * std::sqrt(2.0 / (1.0 + std::sqrt(1.0 + alpha_over_k * alpha_over_k)));
}

// Row 1. As alpha grows the penalty becomes the exact gap constraint; the trapezoidal rule alone then makes energy out
// of the jump of velocity. The multiplier laws do not (TwoBars, KimImpactMultiplierUpdate).
TEST(ExactConstraint, TheTrapezoidalRuleAloneMakesEnergyOfAnImpact) {
  const TemporaryFolder folder;
  for (const auto& [protocol, growth] : {std::pair{"all_implicit", 2.07}, std::pair{"hughes_liu", 4.40}}) {
    const double at_1e4 = unwatched_growth(with_penalty(bars(protocol), 1e4 * bars_k_pa_m), folder);
    const double at_1e6 = unwatched_growth(with_penalty(bars(protocol), 1e6 * bars_k_pa_m), folder);
    EXPECT_NEAR(at_1e6, growth, 0.1 * growth) << protocol;
    EXPECT_NEAR(at_1e6, at_1e4, 0.02 * at_1e4) << protocol << ": it is the limit, not the number, of the penalty";
    EXPECT_LT(unwatched_growth(bars(protocol), folder), 5e-4) << protocol << ": default";
    EXPECT_LT(unwatched_growth(with_key(bars(protocol), "contact", "multiplier_update", "\"fully_implicit\""), folder),
              5e-4);
  }
}

TEST(ExactConstraint, TheWatchNamesThePenalty) {
  const TemporaryFolder folder;
  const RunResult run = run_file(folder.write(with_penalty(bars("all_implicit"), 1e6 * bars_k_pa_m)), folder);
  EXPECT_EQ(run.outcome.code, 3);
  EXPECT_THAT(run.outcome.error, HasSubstr("the contact penalty is too stiff for the step"));
  EXPECT_THAT(run.outcome.error, HasSubstr("lower contact.penalty_pa_m or use enforcement = \"multiplier\""));
}

// Row 2. Courant 1, four impacts; sqrt(2 alpha/m) dt = 2 sqrt(alpha/k) with m = rho A h / 2.
TEST(TrapezoidalPenalty, GainsEnergyFromFourTimesTheWarnedStiffnessOn) {
  const TemporaryFolder folder;
  const auto scene = [](double ratio) {  // of sqrt(2 alpha/m) dt
    return with_step(with_penalty(rod("all_implicit"), ratio * ratio / 4.0 * rod_k_pa_m), rod_element_m);
  };
  const double edge = measured_edge(1.0, 6.3, [&](double ratio) { return grows(scene(ratio), folder); });
  EXPECT_NEAR(edge, 4.67, 0.1 * 4.67);
  EXPECT_NEAR(unwatched_growth(scene(2.0 * std::sqrt(10.0)), folder), 17.6, 1.76) << "alpha = 10 k";
  EXPECT_THAT(check_text(scene(1.01), folder).out, HasSubstr("creates energy at every impact"));
  EXPECT_THAT(check_text(scene(0.99), folder).out, Not(HasSubstr("warning")));
}

// Row 3.
TEST(ExplicitPenalty, IsRefusedBeyondItsCriticalStep) {
  const TemporaryFolder folder;
  for (const double ratio : {1.0, 2.0, 10.0}) {
    const double limit_s = explicit_penalty_limit_s(ratio);
    const auto scene = [&](double share) {
      return with_step(with_penalty(rod("all_explicit"), ratio * rod_k_pa_m), share * limit_s);
    };
    EXPECT_NEAR(measured_edge(0.95, 1.05, [&](double share) { return refused(scene(share), folder); }), 1.0, 0.005)
        << ratio;
    const Outcome beyond = check_text(scene(1.01), folder);
    EXPECT_THAT(beyond.error, HasSubstr("contact.penalty_pa_m: found"));
    EXPECT_THAT(beyond.error, HasSubstr("1.01 times the critical time step"));
  }
}

TEST(ExplicitPenalty, JustBelowItsCriticalStepIsCleanOnlyForASoftOne) {
  const TemporaryFolder folder;
  const auto scene = [&](double ratio, double share) {
    return with_step(with_penalty(rod("all_explicit"), ratio * rod_k_pa_m), share * explicit_penalty_limit_s(ratio));
  };
  EXPECT_LT(unwatched_growth(scene(1.0, 0.99), folder), 0.01) << "alpha = k; measured: 0.3 %";
  const double edge = measured_edge(0.9, 0.99, [&](double share) { return grows(scene(2.0, share), folder); });
  EXPECT_NEAR(edge, 0.968, 0.01) << "alpha = 2 k";
  EXPECT_NEAR(unwatched_growth(scene(2.0, 0.99), folder), 18.2, 1.82) << "alpha = 2 k";
}

// Row 4.
TEST(ExplicitPenalty, ContactThatOpensAndClosesLowersTheLimitOfAStiffOne) {
  const TemporaryFolder folder;
  const auto scene = [&](double share) {
    return with_step(with_penalty(rod("all_explicit"), 10.0 * rod_k_pa_m), share * explicit_penalty_limit_s(10.0));
  };
  const double edge = measured_edge(0.5, 0.9, [&](double share) { return grows(scene(share), folder); });
  EXPECT_NEAR(edge, 0.62, 0.062);
  EXPECT_GT(unwatched_growth(scene(0.8), folder), 0.05) << "chaotic: 9 % or 143 %, by the rounding";
  EXPECT_LT(unwatched_growth(scene(0.49), folder), 0.02) << "measured: 0.9 %";
  EXPECT_THAT(check_text(scene(0.51), folder).out,
              HasSubstr("contact that opens and closes may gain energy above 0.5"));
  EXPECT_THAT(check_text(scene(0.49), folder).out, Not(HasSubstr("warning")));
}

// Row 5. Two bars with the published alpha = 1.31339e9 N/m: released 2 L / c + 1.678347 tau after the impact, tau = Z /
// (2 alpha).
TEST(SoftPenalty, ReleasesLateByTheDelayThatCheckReports) {
  const TemporaryFolder folder;
  const double z = 6.4516e-4 * std::sqrt(206.8e9 * 7844.066), contact_s = 2.0 * 0.254 / std::sqrt(206.8e9 / 7844.066);
  const double delay_s = 1.678347 * z / (2.0 * 1.31339e9);
  EXPECT_NEAR(delay_s / contact_s, 0.168, 0.001);
  for (const char* protocol : {"all_implicit", "hughes_liu", "all_explicit"}) {
    const std::string soft = with_penalty(bars(protocol), 1.31339e9 / 6.4516e-4);
    EXPECT_THAT(check_text(soft, folder).out, HasSubstr("contact lasts about 1.66e-05 s too long (1.678 tau)"));
    EXPECT_NEAR(run_text(soft, folder).summary.at("separation_time_s").get<double>(), 49.456e-6 + contact_s + delay_s,
                2.226e-6);
    EXPECT_NEAR(run_text(bars(protocol), folder).summary.at("separation_time_s").get<double>(), 49.456e-6 + contact_s,
                2 * 2.226e-6);
  }
}

}  // namespace
}  // namespace ricochet::test
