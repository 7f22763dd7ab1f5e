// A participant that takes long to prepare itself says so, and only one that is silent is taken for dead.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string python = source_folder() + "/common/participant/python";

/// explicit_bar.py, whose `initialize` takes 6 s, in the place of one bar of A1 with a deadline of 3 s.
std::string slow_bar(const TemporaryFolder& folder, const std::string& says) {
  std::string text = file_text(python + "/explicit_bar.py");
  text = replaced(text, "import numpy as np\n",
                  "import sys, time\nsys.path.insert(0, \"" + python + "\")\nimport numpy as np\n");
  text =
      replaced(text, "        self.dt = setup[\"window_size_s\"]\n",
               "        self.dt = setup[\"window_size_s\"]\n        for i in range(12):\n            time.sleep(0.5)\n"
               "            " +
                   says + "\n");
  const std::string program = folder.write(text, "slow_bar.py");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  std::string scene = with_key(config_text("two_bars"), "coupling", "timeout_s", "3.0");
  scene = with_key(scene, "coupling", "start_timeout_s", "3.0");
  return scene + "[[participant]]\nname = \"slow\"\nrole = \"explicit\"\nbodies = [\"left\"]\nexecutable = \"" +
         program +
         "\"\n[[participant]]\nname = \"of_right\"\nrole = \"explicit\"\nbodies = [\"right\"]\n"
         "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
}

TEST(SlowSetup, ThatSaysSoIsWaitedFor) {
  const TemporaryFolder folder;
  const auto run = run_text(slow_bar(folder, "self.progress(\"meshing\", i / 12)"), folder);
  EXPECT_THAT(run.outcome.error, AllOf(HasSubstr("set-up: 'slow' meshing, "), HasSubstr(" %")));
  EXPECT_GT(run.summary.at("phases").at("setup_s").get<double>(), 5.5);
}

TEST(SlowSetup, ThatIsSilentIsTakenForDead) {
  const TemporaryFolder folder;
  const auto run = run_file(folder.write(slow_bar(folder, "pass")), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(run.outcome.error, HasSubstr("participant 'slow' has been silent for 3."));
}

/// A participant of which it is known what it said last.
TEST(SlowSetup, ThatFallsSilentIsToldWithItsLastWords) {
  const TemporaryFolder folder;
  const auto run =
      run_file(folder.write(slow_bar(folder, "self.progress(\"meshing\", 0.25) if i == 1 else None")), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(run.outcome.error, HasSubstr("the last it said: meshing, 25 %"));
}

/// All implicit, of some 13 000 nodes: its factorisation takes longer than the deadline.
TEST(Factorisation, ThatTakesLongerThanTheDeadlineIsWaitedForAndShown) {
  const TemporaryFolder folder;
  const std::string text =
      "model = \"solid\"\n[[body]]\nname = \"block\"\n"
      "material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }\n"
      "mesh = { height_m = 0.1, width_m = 0.1, length_m = 0.12, elements = [22, 22, 24] }\n"
      "initial_velocity_m_s = [0.0, 0.0, -1.0]\n"
      "[contact]\nsurfaces = [\"block.start\", \"rigid_plane\"]\n[time]\nstep_s = 4e-6\nend_s = 8e-6\n"
      "[coupling]\nprotocol = \"all_implicit\"\ntimeout_s = 1.5\nstart_timeout_s = 2.5\ntransport = \"shm\"\n";
  const auto run = run_text(text, folder);
  if (run.summary.at("phases").at("setup_s").get<double>() < 3.5) GTEST_SKIP() << "a faster machine";
  EXPECT_THAT(run.outcome.error, HasSubstr("set-up: 'implicit' "));
}

}  // namespace
}  // namespace ricochet::test
