// backward_cone.py: the shares that docs/decisions.md names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/places.hpp"
#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

TEST(BackwardCone, SavesWhatThePageSays) {
  const TemporaryFolder folder;
  std::vector<std::string> command = {"/usr/bin/python3", source_folder() + "/tests/experiments/backward_cone.py"};
  for (const char* name : {"kim_impact", "tile_on_backing", "unequal_bars"})
    command.push_back(source_folder() + "/configs/" + name + ".toml");
  const auto outcome = run_command(command, folder.path().string());
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  for (const char* line :
       {"kim_impact.toml steel reached 87 % useless 15 %",
        "kim_impact.toml carbide reached 90 % "
        "useless 11 %",
        "tile_on_backing.toml striker reached 93 % useless 8 %", "unequal_bars.toml bar reached 66 % useless 44 %"})
    EXPECT_THAT(outcome.out, testing::HasSubstr(line));
}

}  // namespace
}  // namespace ricochet::test
