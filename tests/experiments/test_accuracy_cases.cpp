// accuracy_cases.py and error_bars.py, whose tables stand in docs/accuracy.md, on the cases that take least time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

std::smatch answered(const std::string& out) {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(
      out, found, std::regex(R"((\d) answered, (\d) with a true error within what was asked; (\d) said)")))
      << out;
  return found;
}

Outcome try_cases(const TemporaryFolder& folder, const std::vector<std::string>& more) {
  std::vector<std::string> command{"/usr/bin/python3", source_folder() + "/tests/experiments/accuracy_cases.py",
                                   "--build",          build_folder(),
                                   "--only",           "two_bars 40 contact_impulse"};
  command.insert(command.end(), more.begin(), more.end());
  return run_command(command, folder.path().string(), 120.0);
}

TEST(AccuracyCases, AreAnsweredWithinWhatIsAskedOrRefused) {
  const TemporaryFolder folder;
  const auto outcome = try_cases(folder, {});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto found = answered(outcome.out);
  EXPECT_GE(std::stoi(found[1]), 2) << outcome.out;
  EXPECT_EQ(found[2], found[1]) << outcome.out;
  EXPECT_EQ(std::stoi(found[1]) + std::stoi(found[3]), 4) << outcome.out;
}

TEST(AccuracyCases, AreAllAnsweredWhereFinerMeshesMayBeTaken) {
  const TemporaryFolder folder;
  const auto outcome = try_cases(folder, {"--meshes"});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_EQ(answered(outcome.out)[2], "4") << outcome.out;
}

TEST(AccuracyCases, HaveBarsThatHold) {
  const TemporaryFolder folder;
  const auto outcome = run_command({"/usr/bin/python3", source_folder() + "/tests/experiments/error_bars.py", "--build",
                                    build_folder(), "--only", "unequal_bars, to 100", "--elements", "40", "80"},
                                   folder.path().string(), 120.0);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  std::smatch found;
  ASSERT_TRUE(std::regex_search(outcome.out, found, std::regex(R"((\d+) bars: (\d+) hold, )"))) << outcome.out;
  EXPECT_EQ(found[1], "20") << outcome.out;
  EXPECT_GE(std::stoi(found[2]), 19) << outcome.out;
}

}  // namespace
}  // namespace ricochet::test
