#include "tests/stability/edges.hpp"

// docs/limits.md, 15: the smallest and the largest implicit parts of two bars (A1).

namespace ricochet::test {
namespace {

constexpr double force_n = 1.33453e5, release_s = 148.393e-6, window_s = 2.226e-6;

struct Extreme {
  const char* name;
  const char* lengths_m;
  double energy_gain;  ///< largest, rounded up: without an implicit element at the contact it does gain some
  double energy_at_end;
};

class ExtremePartition : public testing::TestWithParam<Extreme> {};

TEST_P(ExtremePartition, RunsWithTheForceOfTheory) {
  const TemporaryFolder folder;
  const RunResult run =
      run_text(with_key(config_text("two_bars"), "partition", "implicit_length_m", GetParam().lengths_m), folder);
  EXPECT_NEAR(run.summary.at("separation_time_s").get<double>(), release_s, 2.0 * window_s);
  EXPECT_NEAR(run.mean("contact_force_n", 60e-6, 140e-6), force_n, 0.01 * force_n);
  EXPECT_GE(run.smallest("energy_error"), -0.05);
  EXPECT_LE(run.largest("energy_error"), GetParam().energy_gain);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_NEAR(run.last("energy_error"), GetParam().energy_at_end, 0.1 * std::abs(GetParam().energy_at_end));
  RecordProperty("force_deviation", std::to_string(run.deviation("contact_force_n", 60e-6, 140e-6) / force_n));
}

INSTANTIATE_TEST_SUITE_P(TwoBars, ExtremePartition,
                         testing::Values(Extreme{"one_layer", "{ left = 0.0127, right = 0.0127 }", 1e-6, -0.023},
                                         Extreme{"contact_nodes_alone", "{ left = 0.0, right = 0.0 }", 0.035, 0.031},
                                         Extreme{"none_in_one_body", "{ left = 0.0, right = 0.0635 }", 0.015, 0.007},
                                         Extreme{"one_body_whole", "{ left = 1.0, right = 0.0635 }", 5e-3, -0.031},
                                         Extreme{"one_body_whole_none_in_the_other", "{ left = 1.0, right = 0.0 }",
                                                 0.015, 0.0035}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace ricochet::test
