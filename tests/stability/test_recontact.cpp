#include <gmock/gmock.h>

#include "tests/stability/edges.hpp"

// docs/limits.md, row 12: configs/bouncing_bar.toml touches, parts and touches again. Exact as long as the bar does not vibrate:
// fall sqrt(2 h / g), contact 2 L / c, flight 2 v / g.

namespace ricochet::test {
namespace {

constexpr double gravity_m_s2 = 9.81, drop_m = 7.964e-4, contact_s = 2.0 * 1.0 / 1000.0, mass_kg = 0.1;
const double speed_m_s = std::sqrt(2.0 * gravity_m_s2 * drop_m), flight_s = 2.0 * speed_m_s / gravity_m_s2;

struct Touch {
  double begin_s, end_s;
};

/// Contacts of a run; chatter within a tenth of a flight belongs to one contact.
std::vector<Touch> touches(const RunResult& run) {
  std::vector<Touch> list;
  const auto& time = run.column("time_s");
  const auto& open = run.column("pairs_open");
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (open[i] > 0.0) continue;
    if (list.empty() || time[i] - list.back().end_s > 0.1 * flight_s) list.push_back({time[i], time[i]});
    list.back().end_s = time[i];
  }
  return list;
}

std::string scene(const std::string& protocol) { return with_protocol(config_text("bouncing_bar"), protocol); }

class Bounce : public testing::TestWithParam<const char*> {};

TEST_P(Bounce, FollowsTheExactFlightsUntilVibrationsTell) {
  const TemporaryFolder folder;
  const RunResult run = run_text(scene(GetParam()), folder);
  const auto list = touches(run);
  ASSERT_GE(list.size(), 4U);
  EXPECT_NEAR(list[0].begin_s, std::sqrt(2.0 * drop_m / gravity_m_s2), 2e-5);
  // The first contact and the flight after it: no vibration yet, 1/(2n) of the energy lost.
  EXPECT_NEAR(list[0].end_s - list[0].begin_s, contact_s, 0.05 * contact_s);
  int tracked = 0;
  while (tracked + 1 < static_cast<int>(list.size())) {
    const double flown_s = list[static_cast<std::size_t>(tracked) + 1].begin_s - list[static_cast<std::size_t>(tracked)].end_s;
    RecordProperty("flight_" + std::to_string(tracked) + "_of_exact", std::to_string(flown_s / flight_s));
    if (std::abs(flown_s / flight_s - 1.0) > 0.05) break;
    ++tracked;
  }
  RecordProperty("flights_within_5_percent", tracked);
  EXPECT_GE(tracked, 2);
  const double energy_j = 0.5 * mass_kg * speed_m_s * speed_m_s;
  EXPECT_GT(run.last("energy_error"), -0.06);
  EXPECT_LT(run.largest("energy_error"), 0.01);
  EXPECT_NEAR(run.largest("energy_external_j"), energy_j, 0.1 * energy_j) << "the fall, and the way on while it is squeezed";
  EXPECT_GT(run.smallest("gap_min_m"), -1e-15) << "nothing ever penetrates";
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Protocols, Bounce, testing::Values("hughes_liu", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

TEST(BounceMassless, LosesLessOfItsFlightsThanTheDefault) {
  const TemporaryFolder folder;
  const auto third_flight_s = [&](const std::string& law) {
    const RunResult run = run_text(with_key(scene("hughes_liu"), "contact", "multiplier_update", "\"" + law + "\""), folder, law);
    EXPECT_FALSE(run.summary.at("switches").empty()) << law;
    const auto list = touches(run);
    return list.at(3).begin_s - list.at(2).end_s;
  };
  const double massless_s = third_flight_s("massless"), reset_s = third_flight_s("trapezoidal_reset");
  EXPECT_GT(massless_s, 0.96 * flight_s) << "measured: 0.970";
  EXPECT_GT(massless_s, reset_s + 0.005 * flight_s);
}

TEST(BounceSwitch, GoesToExplicitAfterEachSeparationAndBackBeforeEachContact) {
  const TemporaryFolder folder;
  const RunResult run = run_text(scene("hughes_liu"), folder);
  const auto list = touches(run);
  const auto& switches = run.summary.at("switches");
  ASSERT_GE(list.size(), 4U);
  ASSERT_GE(switches.size(), 2 * list.size() - 2);
  for (std::size_t i = 0; i + 1 < list.size(); ++i) {
    const auto &away = switches[2 * i], &back = switches[2 * i + 1];
    EXPECT_EQ(away.at("to"), "explicit");
    EXPECT_EQ(back.at("to"), "implicit");
    EXPECT_GT(away.at("time_s").get<double>(), list[i].end_s);
    EXPECT_LT(away.at("time_s").get<double>(), list[i].end_s + 0.1 * flight_s);
    EXPECT_LT(back.at("time_s").get<double>(), list[i + 1].begin_s);
    EXPECT_GT(back.at("time_s").get<double>(), list[i + 1].begin_s - 0.1 * flight_s);
  }
}

}  // namespace
}  // namespace ricochet::test
