// random_process_sets.py: whatever is drawn, check and run agree, balances hold, protocols agree, and a run that is
// resumed in its middle writes the same bytes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

TEST(RandomProcessSets, KeepWhatEveryRunMustKeep) {
  const TemporaryFolder folder;
  const auto outcome = run_command({"/usr/bin/python3", RICOCHET_SOURCE "/tests/experiments/random_process_sets.py",
                                    "--build", RICOCHET_BUILD, "--seed", "5", "--count", "8"},
                                   folder.path().string(), 300.0);
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  std::smatch found;
  ASSERT_TRUE(std::regex_search(outcome.out, found, std::regex(R"(72 runs, (\d+) refused, 0 wrong)"))) << outcome.out;
  EXPECT_LT(std::stoi(found[1]), 36) << "most are to be computed";
}

}  // namespace
}  // namespace ricochet::test
