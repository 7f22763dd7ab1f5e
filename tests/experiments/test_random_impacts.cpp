// random_impacts.py: whatever is drawn, a run is refused, leaves the model, or keeps momentum and makes no energy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

TEST(RandomImpacts, MakeNoEnergyAndLoseNoMomentum) {
  const TemporaryFolder folder;
  const auto outcome = run_command({"/usr/bin/python3", RICOCHET_SOURCE "/tests/experiments/random_impacts.py",
                                    "--build", RICOCHET_BUILD, "--seed", "3", "--count", "16"},
                                   folder.path().string(), 300.0);
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  std::smatch found;
  ASSERT_TRUE(std::regex_search(outcome.out, found, std::regex(R"(80 runs, (\d+) refused, 0 wrong)"))) << outcome.out;
  EXPECT_LT(std::stoi(found[1]), 40) << "most are to be computed";
}

}  // namespace
}  // namespace ricochet::test
