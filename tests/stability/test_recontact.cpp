#include <gmock/gmock.h>

#include "tests/stability/edges.hpp"

// docs/limits.md, 12: configs/bouncing_bar.toml touches, parts and touches again. Exact as long as the bar does not
// vibrate: fall sqrt(2 h / g), contact 2 L / c, flight 2 v / g.

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

/// Duration of a flight over the exact one.
double flight_of_exact(const std::vector<Touch>& list, std::size_t i) {
  return (list.at(i + 1).begin_s - list.at(i).end_s) / flight_s;
}

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
    if (std::abs(flight_of_exact(list, static_cast<std::size_t>(tracked)) - 1.0) > 0.05) break;
    ++tracked;
  }
  RecordProperty("flights_within_5_percent", tracked);
  EXPECT_GE(tracked, 2);
  const double energy_j = 0.5 * mass_kg * speed_m_s * speed_m_s;
  EXPECT_GT(run.last("energy_error"), -0.06);
  EXPECT_LT(run.largest("energy_error"), 0.01);
  EXPECT_NEAR(run.largest("energy_external_j"), energy_j, 0.1 * energy_j)
      << "the fall, and the way on while it is squeezed";
  EXPECT_GT(run.smallest("gap_min_m"), -1e-15) << "nothing ever penetrates";
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Protocols, Bounce, testing::Values("hughes_liu", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

// The table of the page.
TEST(BounceFlights, AreShorterEachTimeAndByLessWithMasslessContactNodes) {
  struct Row {
    const char *protocol, *law;
    double flights[3];
  };
  for (const Row& row :
       {Row{"hughes_liu", "trapezoidal_reset", {0.988, 0.973, 0.957}},
        Row{"all_implicit", "trapezoidal_reset", {0.981, 0.957, 0.924}}, Row{"all_explicit", "", {0.989, 0.975, 0.957}},
        Row{"hughes_liu", "massless", {0.992, 0.979, 0.964}}, Row{"all_implicit", "massless", {0.983, 0.959, 0.944}},
        Row{"belytschko_mullen", "massless", {0.992, 0.983, 0.967}},
        Row{"all_explicit", "massless", {0.994, 0.984, 0.971}}}) {
    const TemporaryFolder folder;
    const std::string law = row.law, text = scene(row.protocol);
    const RunResult run =
        run_text(law.empty() ? text : with_key(text, "contact", "multiplier_update", "\"" + law + "\""), folder);
    EXPECT_EQ(run.summary.at("switches").empty(), std::string(row.protocol) != "hughes_liu");
    const auto list = touches(run);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(flight_of_exact(list, i), row.flights[i], 0.1 * (1.0 - row.flights[i]))
          << row.protocol << " " << law << " " << i + 1;
    }
  }
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
