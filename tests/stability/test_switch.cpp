#include <map>

#include "tests/stability/edges.hpp"
#include "tests/support/vtu.hpp"

// docs/limits.md, 11: what the switch to explicit integration costs, measured in the metric that central difference
// conserves.

namespace ricochet::test {
namespace {

constexpr double area_m2 = 6.4516e-4, modulus_pa = 206.8e9, density_kg_m3 = 7844.066, window_s = 2.226e-6;

/// Both bars of configs/two_bars.toml at one time: nodes by position.
struct Bars {
  std::vector<double> x, u, v, mass, force;  ///< force: K u

  Bars(const std::string& results, int window) {
    std::map<double, std::pair<double, double>> nodes;  // shared nodes: the implicit side integrates them
    for (const std::string participant : {"explicit", "implicit"}) {
      const auto files = field_files(results, participant, window);
      const auto position = vtu_array(files, "Points"), displacement = vtu_array(files, "displacement"),
                 velocity = vtu_array(files, "velocity");
      for (std::size_t i = 0; i < position.size(); i += 3) nodes[position[i]] = {displacement[i], velocity[i]};
    }
    for (const auto& [at, motion] : nodes) {
      x.push_back(at);
      u.push_back(motion.first);
      v.push_back(motion.second);
    }
    mass.assign(x.size(), 0.0);
    force.assign(x.size(), 0.0);
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      const double length = x[i + 1] - x[i];
      if (x[i] == 0.0) continue;  // the gap
      const double pull = modulus_pa * area_m2 / length * (u[i + 1] - u[i]);
      force[i] -= pull;
      force[i + 1] += pull;
      mass[i] += 0.5 * density_kg_m3 * area_m2 * length;
      mass[i + 1] += 0.5 * density_kg_m3 * area_m2 * length;
    }
  }
  /// 1/2 w M w + 1/2 u K (u + dt w) of the half step that starts here with velocity w = v + share dt a: with share 1/2,
  /// what central difference conserves.
  [[nodiscard]] double staggered_energy_j(double share) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double w = v[i] - share * window_s * force[i] / mass[i];
      sum += 0.5 * mass[i] * w * w + 0.5 * force[i] * (u[i] + window_s * w);
    }
    return sum;
  }
};

TEST(Switch, CostsNothingInTheStaggeredMetric) {
  const TemporaryFolder folder;
  const RunResult run = run_text(with_key(config_text("two_bars"), "output", "fields_every", "1"), folder);
  ASSERT_EQ(run.summary.at("switches").size(), 1U);
  const int switched =
      static_cast<int>(std::lround(run.summary.at("switches")[0].at("time_s").get<double>() / window_s));
  ASSERT_LT(switched + 10, run.summary.at("windows").get<int>());
  const Bars before(run.folder, switched);
  ASSERT_EQ(before.x.size(), 42U);
  const double energy_j = before.staggered_energy_j(0.5);
  for (int window = switched + 1; window <= switched + 10; ++window) {
    EXPECT_NEAR(Bars(run.folder, window).staggered_energy_j(0.5), energy_j, 1e-10 * energy_j) << window;
  }
  // The other side: had it started with v_n in the place of v_{n+1/2}.
  const double wrong = std::abs(before.staggered_energy_j(0.0) - energy_j) / energy_j;
  RecordProperty("wrong_half_velocity_costs", std::to_string(wrong));
  EXPECT_NEAR(wrong, 0.005, 0.0005);
}

TEST(Switch, ShowsTheChangeOfMetricInTheHistory) {
  const TemporaryFolder folder;
  const RunResult run = run_text(config_text("two_bars"), folder);
  const auto& error = run.column("energy_error");
  const auto at =
      static_cast<std::size_t>(std::lround(run.summary.at("switches")[0].at("time_s").get<double>() / window_s));
  EXPECT_NEAR(error[at + 1] - error[at], -1.12e-3, 0.1e-3);
  for (std::size_t i = at + 1; i < error.size(); ++i) EXPECT_NEAR(error[i], error[at + 1], 1e-13);
}

/// Two elements in each bar, one of them implicit: what is explicit alone would stand 1.155 of the step that the whole
/// bar does.
TEST(Switch, StaysImplicitWhereTheWholeBodyCouldNotFollow) {
  const TemporaryFolder folder;
  std::string text = config_text("two_bars");
  for (int bar = 0; bar < 2; ++bar) text = replaced(text, "elements = 20", "elements = 2");
  text = replaced(text, "{ left = 0.0635, right = 0.0635 }", "{ left = 0.127, right = 0.127 }");
  text = replaced(replaced(text, "step_s = 2.226e-6", ""), "end_s = 250e-6", "end_s = 5e-3");
  const RunResult run = run_text(text, folder);
  EXPECT_TRUE(run.summary.at("switches").empty());
  EXPECT_NE(run.outcome.out.find("'implicit' stays implicit after separation: explicit and implicit elements of body"),
            std::string::npos);
  EXPECT_LT(run.largest("energy_error"), 0.05);
  const Outcome check = check_text(text, folder);
  EXPECT_NE(check.out.find("note: the implicit side stays implicit after separation"), std::string::npos) << check.out;
}

/// The implicit side of contact nodes alone has no elements, and no limit of its own.
TEST(Switch, ContactNodesAloneCanDoIt) {
  const TemporaryFolder folder;
  const std::string text =
      replaced(config_text("two_bars"), "{ left = 0.0635, right = 0.0635 }", "{ left = 0.0, right = 0.0 }");
  EXPECT_EQ(run_text(text, folder).summary.at("switches").size(), 1U);
}

}  // namespace
}  // namespace ricochet::test
