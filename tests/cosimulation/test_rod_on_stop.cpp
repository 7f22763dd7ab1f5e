#include "tests/support/run.hpp"
#include "tests/support/vtu.hpp"

// Acceptance A2, configs/rod_on_stop.toml: a compressed rod springs against a stop four times (period 3).

namespace ricochet::test {
namespace {

/// Exact displacement, acceptance A2.
double exact(double x, double t) {
  const int n = static_cast<int>(std::floor(std::fmod(t, 3.0)));
  const double f = t - std::floor(t);
  const bool below = f < x,
             before = f <= 1.0 - x;  // zones: I below & before, II !below & before, III below & !before, IV
  if (n == 0) return below ? 0.5 - x / 2 : 0.5 - f / 2;
  if (n == 1) {
    if (below) return before ? -f / 2 : -0.5 + x / 2;
    return before ? -x / 2 : -0.5 + f / 2;
  }
  return before ? f / 2 : 0.5 - x / 2;
}

/// Trapezoidal integral over the nodes of one snapshot of one participant, which holds x from its smallest to largest
/// node.
double squared_error(const std::vector<std::string>& files, double t) {
  const auto position = vtu_array(files, "Points"), displacement = vtu_array(files, "displacement");
  double sum = 0.0;
  const auto at = [&](std::size_t i) {
    const double e = displacement[3 * i] - exact(position[3 * i], t);
    return e * e;
  };
  for (std::size_t i = 0; i + 1 < position.size() / 3; ++i) {
    sum += 0.5 * (at(i) + at(i + 1)) * (position[3 * i + 3] - position[3 * i]);
  }
  return sum;
}

/// Error of u in L2(0, T; L2): square root of the time mean of the squared L2 norm in space, times sqrt(T).
double displacement_error(const RunResult& run, const std::vector<std::string>& participants, double window_s,
                          int windows) {
  double sum = 0.0;
  for (int n = 1; n <= windows; ++n) {
    for (const auto& participant : participants)
      sum += window_s * squared_error(field_files(run.folder, participant, n), n * window_s);
  }
  return std::sqrt(sum);
}

struct Level {
  const char* protocol;
  std::vector<std::string> participants;
  double displacement_error;
};

class RodOnStop : public testing::TestWithParam<Level> {};

TEST_P(RodOnStop, StaysWithinItsLevelsOverFourImpacts) {
  const Level& level = GetParam();
  const TemporaryFolder folder;
  const RunResult run = run_text(
      with_key(with_protocol(config_text("rod_on_stop"), level.protocol), "output", "fields_every", "1"), folder);
  const double window_s = run.summary.at("window_size_s").get<double>();
  const int windows = run.summary.at("windows").get<int>();
  EXPECT_NEAR(windows * window_s, 12.0, 2.0 * window_s);
  EXPECT_NEAR(window_s, 0.009, 1e-4) << "Courant 0.9";
  const double error = displacement_error(run, level.participants, window_s, windows);
  EXPECT_LE(error, level.displacement_error);
  EXPECT_GE(error, 0.2 * level.displacement_error) << "too good to be this scene";
  EXPECT_GT(run.last("energy_error"), -0.013);
  EXPECT_LT(run.last("energy_error"), 0.001);
}

TEST_P(RodOnStop, PushesWithHalfTheForceWhileItTouches) {
  const TemporaryFolder folder;
  const RunResult run = run_text(with_protocol(config_text("rod_on_stop"), GetParam().protocol), folder);
  for (const double begin : {1.0, 4.0, 7.0, 10.0}) {
    EXPECT_NEAR(run.mean("contact_force_n", begin + 0.1, begin + 0.9), 0.5, 0.015) << "from t = " << begin << " s";
    EXPECT_EQ(run.mean("contact_force_n", begin + 1.2, begin + 1.9), 0.0);
  }
  EXPECT_LT(run.deviation("contact_force_n", 1.1, 1.9), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Protocols, RodOnStop,
                         testing::Values(Level{"hughes_liu", {"explicit", "implicit"}, 1.5e-2},
                                         Level{"all_explicit", {"explicit"}, 1.9e-2},
                                         Level{"all_implicit", {"implicit"}, 2.6e-2}),
                         [](const auto& test) { return std::string(test.param.protocol); });

}  // namespace
}  // namespace ricochet::test
