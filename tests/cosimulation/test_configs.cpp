#include <filesystem>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

// Every scene in configs/ runs, keeps its balances and leaves every file it promises.

namespace ricochet::test {
namespace {

std::vector<std::string> scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() + "/configs")) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class EveryConfig : public testing::TestWithParam<std::string> {};

TEST_P(EveryConfig, RunsAndKeepsItsBalances) {
  const TemporaryFolder folder;
  const RunResult run = run_file(source_folder() + "/configs/" + GetParam() + ".toml", folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  EXPECT_EQ(run.summary.at("status"), run.summary.at("outside_model").empty() ? "done" : "left_model");
  EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 0.04);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
  for (const char* file : {"history.csv", "summary.json", "trace.json", "report.html"}) {
    EXPECT_TRUE(std::filesystem::exists(run.folder + "/" + file)) << file;
  }
  EXPECT_GT(run.column("time_s").size(), 100U);
}

INSTANTIATE_TEST_SUITE_P(Configs, EveryConfig, testing::ValuesIn(scenes()),
                         [](const auto& test) { return test.param; });

TEST(Configs, ThereAreSome) { EXPECT_GE(scenes().size(), 7U); }

}  // namespace
}  // namespace ricochet::test
