#include <gmock/gmock.h>

#include "tests/stability/edges.hpp"

// docs/limits.md, 13 and 14: stiff regularised friction, and Poisson's ratio near one half.

namespace ricochet::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The sticking plates with regularised friction, xi = 1 s/m, and all velocities times `factor`: mu N dt / (2 m) is 2.7
/// m/s times that, against 1/xi = 1 m/s.
std::string plates(const std::string& protocol, double factor) {
  std::string text =
      with_key(with_protocol(config_text("sticking_plates"), protocol), "contact", "friction_law", "\"regularised\"");
  for (const double sign : {1.0, -1.0}) {
    const std::string from = sign > 0 ? "[3.0, 10.0]" : "[-3.0, -10.0]";
    text = replaced(text, from,
                    std::string("[") + number(3.0 * sign * factor) + ", " + number(10.0 * sign * factor) + "]");
  }
  return replaced(text, "end_s = 600e-6", "end_s = 400e-6");
}

/// Each plate's shear wave: tau = rho c_S (v_t - v/2), and tau = mu p tanh(xi v): the traction [Pa] of two plates that
/// slide at v.
double exact_traction_pa(double factor) {
  const double c_s = std::sqrt(1e9 / (2 * 1000 * 1.25)), limit_pa = 3.28634e6 * factor;
  double low = 0.0, high = 6.0 * factor;
  for (int i = 0; i < 200; ++i) {
    const double v = 0.5 * (low + high);
    (limit_pa * std::tanh(v) > 1000 * c_s * (3.0 * factor - 0.5 * v) ? high : low) = v;
  }
  return 1000 * c_s * (3.0 * factor - 0.5 * low);
}

// Row 13. Friction by impulses asks for the velocity that it leaves: however stiff the law is for the step, nothing
// rings.
class RegularisedFriction : public testing::TestWithParam<const char*> {};

TEST_P(RegularisedFriction, HasTheExactMeanTractionAndDoesNotRing) {
  const TemporaryFolder folder;
  for (const double factor : {1.0, 10.0}) {  // 1/xi is 2.7 and 27 times less than mu N dt/(2 m)
    const RunResult run =
        run_text(with_key(plates(GetParam(), factor), "coupling", "outside_model", "\"go_on\""), folder);
    const double traction_pa = std::abs(run.mean("friction_force_n", 100e-6, 400e-6)) / 0.0075;
    EXPECT_NEAR(traction_pa, exact_traction_pa(factor), 2e-3 * exact_traction_pa(factor)) << factor;
    EXPECT_LT(run.deviation("friction_force_n", 50e-6, 100e-6),
              0.02 * std::abs(run.mean("friction_force_n", 50e-6, 100e-6)))
        << factor;
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, RegularisedFriction, testing::Values("all_implicit", "hughes_liu", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

TEST(RegularisedFrictionOfAPenalty, IsWarnedOfWhereNoVelocityIsSet) {
  const TemporaryFolder folder;
  const auto checked = [&](const std::string& update) {
    std::string text = with_key(plates("all_implicit", 4.0), "contact", "enforcement", "\"penalty\"");
    text =
        with_key(with_key(text, "contact", "penalty_pa_m", "1e10"), "contact", "impact_update", "\"" + update + "\"");
    return check_text(text, folder).out;
  };
  EXPECT_THAT(checked("none"), HasSubstr("the friction force rings after an impact"));
  EXPECT_THAT(checked("mass"), Not(HasSubstr("rings")));
  EXPECT_THAT(check_text(plates("hughes_liu", 4.0), folder).out, Not(HasSubstr("rings")));
}

// Row 14.
TEST(PoissonRatio, IsRefusedFromOneHalfAndWarnedAbove049) {
  const TemporaryFolder folder;
  const auto checked = [&](const std::string& ratio) {
    std::string text = replaced(config_text("sticking_plates"), "poisson_ratio = 0.25", "poisson_ratio = " + ratio);
    return check_text(replaced(text, "poisson_ratio = 0.25", "poisson_ratio = " + ratio), folder);
  };
  EXPECT_THAT(checked("0.49").out, Not(HasSubstr("incompressible")));
  EXPECT_THAT(checked("0.4901").out, HasSubstr("elements lock and the wave speed"));
  EXPECT_EQ(checked("0.4999").code, 0);
  EXPECT_EQ(checked("0.5").code, 2);
  EXPECT_THAT(checked("0.5").error, HasSubstr("poisson_ratio"));
}

// c_L grows like 1/sqrt(1 - 2 nu), and the step falls with it.
TEST(PoissonRatio, CostsTimeStepsAsItNearsOneHalf) {
  const TemporaryFolder folder;
  const auto window_s = [&](const std::string& ratio) {
    std::string text = replaced(config_text("sticking_plates"), "poisson_ratio = 0.25", "poisson_ratio = " + ratio);
    text =
        replaced(replaced(text, "poisson_ratio = 0.25", "poisson_ratio = " + ratio), "end_s = 600e-6", "end_s = 2e-6");
    return run_text(text, folder).summary.at("window_size_s").get<double>();
  };
  EXPECT_NEAR(window_s("0.49") / window_s("0.4999"), std::sqrt(0.02 / 0.0002), 0.05 * 10.0);
}

}  // namespace
}  // namespace ricochet::test
