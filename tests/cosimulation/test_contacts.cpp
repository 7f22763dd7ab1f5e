// Scenes with several contacts.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

/// Three equal bars end to end, touching; the first flies at 2 m/s. c = 1000 m/s, length 0.1 m, Z = rho c A = 1e6 A.
std::string three_bars(const std::string& protocol, const std::string& multiplier_update) {
  std::string text = "model = \"bar\"\n";
  for (int i = 0; i < 3; ++i) {
    text += fmt::format(R"([[body]]
name = "{}"
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.0, density_kg_m3 = 1000.0 }}
area_m2 = 1e-4
mesh = {{ start_m = {}, length_m = 0.1, elements = 100 }}
initial_velocity_m_s = [{}]
)",
                        "abc"[i], 0.1 * i, i == 0 ? 2.0 : 0.0);
  }
  return text + fmt::format(R"([[contact]]
name = "first"
surfaces = ["a.end", "b.start"]
multiplier_update = "{}"
[[contact]]
name = "second"
surfaces = ["b.end", "c.start"]
[partition]
implicit_length_m = {{ a = 2e-3, b = 2e-3, c = 2e-3 }}
[time]
safety_factor = 0.99
end_s = 6e-4
[coupling]
protocol = "{}"
)",
                            multiplier_update, protocol);
}

class ThreeBars : public testing::TestWithParam<const char*> {};

/// Newton's cradle: the pulse of v/2 runs through the second bar into the third, which leaves at t = 3 L/c with all
/// of the velocity. Either contact hands over the momentum m v; on the way b is pressed from both sides. (The
/// trapezoidal rule leaves 1.5 % of it in the middle, which it disperses.)
TEST_P(ThreeBars, HandTheirMomentumOn) {
  const TemporaryFolder folder;
  const RunResult r = run_text(three_bars(GetParam(), "trapezoidal_reset"), folder);
  EXPECT_NEAR(r.last("velocity_mean_a_m_s"), 0.0, 0.04);
  EXPECT_NEAR(r.last("velocity_mean_b_m_s"), 0.0, 0.04);
  EXPECT_NEAR(r.last("velocity_mean_c_m_s"), 2.0, 0.04);
  const double force = 1e6 * 1e-4 * 1.0;  // Z v/2, at one contact or at both
  EXPECT_NEAR(r.mean("contact_force_n", 0.2e-4, 0.9e-4), force, 0.01 * force) << "before the wave is at the second";
  EXPECT_NEAR(r.mean("contact_force_n", 1.2e-4, 1.9e-4), 2.0 * force, 0.02 * force) << "at both";
  EXPECT_NEAR(r.mean("contact_force_n", 2.2e-4, 2.9e-4), force, 0.02 * force) << "at the second alone";
  EXPECT_NEAR(r.last("contact_impulse_n_s"), 2.0 * 0.01 * 2.0, 2e-4);
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
}

/// Each contact is told to have given what its bars have: the first m v_a less, the second m v_c more. The
/// pulse of v/2 lasts 2 L/c at either, and reaches the second L/c later.
TEST_P(ThreeBars, AreToldOfByContact) {
  const TemporaryFolder folder;
  const RunResult r = run_text(three_bars(GetParam(), "trapezoidal_reset"), folder);
  const double mass_kg = 0.01, force = 100.0, wave_s = 1e-4;
  EXPECT_NEAR(r.last("contact_impulse_n_s/first"), mass_kg * (2.0 - r.last("velocity_mean_a_m_s")), 1e-12);
  EXPECT_NEAR(r.last("contact_impulse_n_s/second"), mass_kg * r.last("velocity_mean_c_m_s"), 1e-12);
  const auto &sum = r.column("contact_force_n"), &first = r.column("contact_force_n/first"),
             &second = r.column("contact_force_n/second");
  for (std::size_t i = 0; i < sum.size(); ++i) ASSERT_NEAR(first[i] + second[i], sum[i], 1e-11 * force) << i;
  EXPECT_NEAR(r.mean("contact_force_n/first", 0.2e-4, 1.9e-4), force, 0.01 * force);
  EXPECT_LT(r.mean("contact_force_n/second", 0.0, 0.8e-4), 1e-6 * force) << "no wave has reached it";
  EXPECT_NEAR(r.mean("contact_force_n/second", 1.2e-4, 2.9e-4), force, 0.01 * force);
  EXPECT_EQ(r.last("pairs_open/first"), 1.0);
  EXPECT_GT(r.last("gap_min_m/second"), 1e-6);
  EXPECT_EQ(r.history.count("friction_force_b_n/first"), 0U) << "of solids alone";
  const auto& contacts = r.summary.at("contacts");
  EXPECT_NEAR(contacts.at("second").at("first_contact_s").get<double>(), wave_s, 0.4 * wave_s);
  EXPECT_NEAR(contacts.at("second").at("separation_time_s").get<double>(), 3.0 * wave_s, 0.1 * wave_s);
  EXPECT_EQ(contacts.at("second").at("contact_impulse_n_s").get<double>(), r.last("contact_impulse_n_s/second"));
  const double peak_n = contacts.at("first").at("peak_contact_force_n").get<double>();
  EXPECT_GT(peak_n, 0.99 * force);
  EXPECT_LE(peak_n, r.largest("contact_force_n/first"));
  EXPECT_EQ(contacts.at("first").count("friction_impulse_b_n_s"), 0U);
  EXPECT_THAT(r.outcome.out, testing::HasSubstr("contact 'second'"));
  // Bars in series hand one force on: a sum would be twice what any of them feels.
  EXPECT_TRUE(r.summary.at("peak_contact_force_n").is_null());
  EXPECT_TRUE(r.summary.at("contact_impulse_n_s").is_null());
  EXPECT_THAT(r.outcome.out, testing::Not(testing::HasSubstr("peak contact force")));
  const std::string page = file_text(r.folder + "/report.html");
  EXPECT_THAT(page, testing::HasSubstr("contact second"));
  EXPECT_THAT(page, testing::Not(testing::HasSubstr("peak contact force")));
}

INSTANTIATE_TEST_SUITE_P(Protocols, ThreeBars,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

TEST(ThreeBarsMassless, HandTheirMomentumOn) {
  for (const char* protocol : {"hughes_liu", "all_implicit", "all_explicit"}) {
    const TemporaryFolder folder;
    const RunResult r = run_text(three_bars(protocol, "massless"), folder);
    EXPECT_NEAR(r.last("velocity_mean_c_m_s"), 2.0, 0.04) << protocol;
    EXPECT_NEAR(r.last("velocity_mean_b_m_s"), 0.0, 0.04) << protocol;
    EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10) << protocol;
  }
}

}  // namespace
}  // namespace ricochet::test
