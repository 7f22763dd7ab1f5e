// accuracy_cases.py, whose table stands in docs/accuracy.md, on the cases that take least time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

TEST(AccuracyCases, AreAnsweredWithinWhatIsAskedOrRefused) {
  const TemporaryFolder folder;
  const auto outcome = run_command({"/usr/bin/python3", RICOCHET_SOURCE "/tests/experiments/accuracy_cases.py",
                                    "--build", RICOCHET_BUILD, "--only", "two_bars 40 contact_impulse"},
                                   folder.path().string(), 120.0);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  std::smatch found;
  ASSERT_TRUE(std::regex_search(
      outcome.out, found, std::regex(R"((\d) answered, (\d) with a true error within what was asked; (\d) said)")))
      << outcome.out;
  EXPECT_GE(std::stoi(found[1]), 2) << outcome.out;
  EXPECT_EQ(found[2], found[1]) << outcome.out;
  EXPECT_EQ(std::stoi(found[1]) + std::stoi(found[3]), 4) << outcome.out;
}

}  // namespace
}  // namespace ricochet::test
