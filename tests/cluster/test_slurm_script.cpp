// The script that the command writes for Slurm; on a Slurm it is tried in the tests beside this one.
#include <gmock/gmock.h>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

class SlurmScript : public testing::Test {
 protected:
  Outcome write(const std::string& launcher, std::vector<std::string> options = {}, const std::string& name = "scene",
                const std::string& participants = "") {
    const auto text = with_key(config_text("two_bars"), "coupling", "launcher", "\"" + launcher + "\"") + participants;
    options.insert(options.begin(), {ricochet_binary(), "slurm-script", folder_.write(text, name + ".toml")});
    return run_command(options, folder_.path().string());
  }
  TemporaryFolder folder_;
};

TEST_F(SlurmScript, AsksForAProcessorForEachProcess) {
  const auto outcome = write("slurm", {"--time", "1-02:30"});
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  for (const char* line : {"#!/bin/bash\n", "\n#SBATCH --job-name=scene\n", "\n#SBATCH --ntasks=3\n",
                           "\n#SBATCH --time=1-02:30\n", "\n#SBATCH --signal=B:TERM@60\n", "\n#SBATCH --requeue\n"})
    EXPECT_THAT(outcome.out, HasSubstr(line));
}

TEST_F(SlurmScript, OfASceneThatIsLaunchedLocallyAsksForOneNode) {
  const auto outcome = write("local");
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr("\n#SBATCH --nodes=1 --ntasks=1 --cpus-per-task=3\n"));
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("--time"))) << "the limit is the partition's";
}

/// A line that ended in it would be followed by one of somebody else's.
TEST_F(SlurmScript, OfAPathWithControlCharactersIsRefused) {
  for (const std::string name : {"a\ntouch mark; #", "a\tb", "a\rb"}) {
    const auto outcome = write("local", {}, name);
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_THAT(outcome.error, HasSubstr("found a control character in this path, allowed is none in a batch script"));
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(SlurmScript, GoesOnWithTheSceneThatItNames) {
  EXPECT_THAT(write("local").out, HasSubstr("\"$ricochet\" resume \"$results\" --scene \"$scene\" &\n"));
}

TEST_F(SlurmScript, AsksForAProcessorForEachThread) {
  const std::string participants =
      "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\nthreads = 4\n"
      "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\n";
  const auto local = write("local", {}, "scene", participants), slurm = write("slurm", {}, "scene", participants);
  EXPECT_THAT(local.out, HasSubstr("\n#SBATCH --nodes=1 --ntasks=1 --cpus-per-task=6\n")) << local.error;
  EXPECT_THAT(slurm.out, HasSubstr("\n#SBATCH --ntasks=3 --cpus-per-task=4\n")) << slurm.error;
}

TEST_F(SlurmScript, AsksForAProcessorForEachRank) {
  const std::string participants =
      "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n"
      "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\nranks = 5\n";
  const auto local = write("local", {}, "scene", participants), slurm = write("slurm", {}, "scene", participants);
  EXPECT_THAT(local.out, HasSubstr("\n#SBATCH --nodes=1 --ntasks=1 --cpus-per-task=7\n")) << local.error;
  EXPECT_THAT(slurm.out, HasSubstr("\n#SBATCH --ntasks=7\n")) << slurm.error;
}

/// Run by the shell, with programs in the place of Slurm's: any path is one word, and the results folder may be named.
TEST_F(SlurmScript, IsRunByTheShellWhateverThePathsHold) {
  const auto script = (folder_.path() / "job.sh").string(), out = (folder_.path() / "it's out").string();
  const auto written = write("local", {"--out", script}, "it's a scene");
  ASSERT_EQ(written.code, 0) << written.error;
  EXPECT_THAT(file_text(script), HasSubstr("\n#SBATCH --job-name=it_s_a_scene\n"));
  for (int i = 0; i < 2; ++i) {
    const auto outcome = run_command({"/bin/bash", script, out}, folder_.path().string());
    ASSERT_EQ(outcome.code, 0) << outcome.error;
  }
  EXPECT_TRUE(std::filesystem::exists(out + "/history.csv"));
}

TEST_F(SlurmScript, ReplacesNoFileAndTakesNoTimeThatSlurmDoesNotKnow) {
  const auto taken = folder_.write("mine", "job.sh");
  const auto refused = write("slurm", {"--out", taken});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.error, HasSubstr("job.sh exists already"));
  EXPECT_EQ(file_text(taken), "mine");
  const auto unnamed = write("slurm", {"--out", folder_.path().string() + "/" + std::string(300, 'n')});
  EXPECT_THAT(unnamed.error, HasSubstr("cannot write "));
  const auto wrong = write("slurm", {"--time", "an hour"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.error, HasSubstr("--time: found \"an hour\", allowed: MINUTES"));
}

}  // namespace
}  // namespace ricochet::test
