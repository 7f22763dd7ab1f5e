#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/base/error.hpp"
#include "coupler/processes/executable.hpp"
#include "coupler/processes/launcher.hpp"

namespace ricochet::coupler {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

class LauncherTest : public testing::Test {
 protected:
  std::string folder_ = testing::TempDir() + "launcher_" + std::to_string(getpid());
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] LaunchRequest request(const std::string& name, const std::string& program,
                                      std::vector<std::string> arguments) const {
    return {name, program, std::move(arguments), folder_ + "/" + name + ".log"};
  }
};

bool exists(std::int64_t process) { return kill(static_cast<pid_t>(process), 0) == 0; }

/// True once the launcher has something to say; the signals it hears interrupt the wait.
bool readable(const Launcher& launcher) {
  pollfd wait{launcher.file_descriptor(), POLLIN, 0};
  int result = 0;
  while ((result = poll(&wait, 1, 5000)) < 0 && errno == EINTR) {
  }
  return result == 1;
}

TEST_F(LauncherTest, ALogThatCannotBeOpenedIsNamed) {
  Launcher launcher;
  auto nowhere = request("x", "/bin/true", {});
  nowhere.log_path = folder_ + "/missing/x.log";
  try {
    launcher.launch(nowhere);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("cannot write " + nowhere.log_path), std::string::npos);
  }
  EXPECT_FALSE(launcher.launched("x"));
  launcher.launch(request("y", "/bin/true", {}));  // and goes on
  EXPECT_TRUE(launcher.wait_all(std::chrono::milliseconds(5000)));
}

TEST_F(LauncherTest, ExitCodesOutputAndSignalsAreSeen) {
  Launcher launcher;
  launcher.launch(request("good", "/bin/sh", {"-c", "echo to stdout; echo to stderr >&2"}));
  launcher.launch(request("bad", "/bin/sh", {"-c", "exit 3"}));
  launcher.launch(request("killed", "/bin/sh", {"-c", "kill -9 $$"}));
  ASSERT_TRUE(launcher.wait_all(milliseconds(10000)));
  EXPECT_EQ(launcher.end_of("good")->text(), "ended with exit code 0");
  EXPECT_EQ(launcher.end_of("bad")->text(), "ended with exit code 3");
  EXPECT_EQ(launcher.end_of("killed")->text(), "was killed by signal 9 (SIGKILL)");
  EXPECT_EQ(launcher.events(), 3);
  EXPECT_THAT(last_lines(launcher.log_path("good"), 5), AllOf(HasSubstr("to stdout"), HasSubstr("to stderr")));
}

TEST_F(LauncherTest, DeathWakesTheFileDescriptorAtOnce) {
  Launcher launcher;
  launcher.launch(request("sleeper", "/bin/sleep", {"100"}));
  EXPECT_FALSE(launcher.end_of("sleeper"));
  kill(static_cast<pid_t>(launcher.process_id("sleeper")), SIGKILL);
  for (int i = 0; i < 100 && !launcher.end_of("sleeper"); ++i) {
    ASSERT_TRUE(readable(launcher));
    launcher.poll();
  }
  EXPECT_EQ(launcher.end_of("sleeper")->signal, SIGKILL);
}

TEST_F(LauncherTest, StopEndsEveryoneAlsoTheStoppedAndTheDeaf) {
  Launcher launcher;
  launcher.launch(request("plain", "/bin/sleep", {"100"}));
  launcher.launch(request("stopped", "/bin/sleep", {"100"}));
  launcher.launch(request("deaf", "/bin/sh", {"-c", "trap '' TERM; echo ready; while :; do sleep 0.05; done"}));
  while (last_lines(launcher.log_path("deaf"), 1).empty()) usleep(10000);
  kill(static_cast<pid_t>(launcher.process_id("stopped")), SIGSTOP);
  launcher.stop(milliseconds(300));
  EXPECT_EQ(launcher.end_of("plain")->signal, SIGTERM);
  EXPECT_EQ(launcher.end_of("stopped")->signal, SIGTERM);
  EXPECT_EQ(launcher.end_of("deaf")->signal, SIGKILL);
}

TEST_F(LauncherTest, DestructorLeavesNoOrphanNorItsChildren) {
  std::int64_t process = 0, child = 0;
  {
    Launcher launcher;
    launcher.launch(request("wrapper", "/bin/sh", {"-c", "sleep 100 & echo $!; wait"}));
    std::string line;
    while ((line = last_lines(launcher.log_path("wrapper"), 1)).empty()) usleep(10000);
    child = std::stoll(line);
    process = launcher.process_id("wrapper");
    EXPECT_TRUE(exists(process));
  }
  EXPECT_FALSE(exists(process));
  for (int i = 0; i < 200 && exists(child); ++i) usleep(10000);
  EXPECT_FALSE(exists(child));
}

TEST_F(LauncherTest, StandardInputClosesWhenTheLauncherDies) {
  const pid_t coupler = fork();
  if (coupler == 0) {
    Launcher launcher;
    launcher.launch(request("reader", "/bin/sh", {"-c", "cat; echo end of input"}));
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(coupler, &status, 0);
  for (int i = 0; i < 500 && last_lines(folder_ + "/reader.log", 1).empty(); ++i) usleep(10000);
  EXPECT_THAT(last_lines(folder_ + "/reader.log", 1), HasSubstr("end of input"));
}

TEST_F(LauncherTest, ChildrenInheritOnlyStandardFiles) {
  const int leak = open("/dev/null", O_RDONLY);  // no O_CLOEXEC: as if inherited from a careless parent
  Launcher launcher;
  launcher.launch(request("sleeper", "/bin/sleep", {"100"}));
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator("/proc/" + std::to_string(launcher.process_id("sleeper")) + "/fd")) {
    files.push_back(entry.path().filename());
  }
  close(leak);
  EXPECT_THAT(files, testing::UnorderedElementsAre("0", "1", "2"));
}

TEST_F(LauncherTest, MissingProgramIsAParticipantError) {
  Launcher launcher;
  try {
    launcher.launch(request("ghost", "/nonexistent/solver", {}));
    FAIL();
  } catch (const ParticipantError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("'ghost'"), HasSubstr("/nonexistent/solver")));
  }
  EXPECT_FALSE(launcher.launched("ghost"));
  EXPECT_TRUE(launcher.wait_all(milliseconds(0)));
}

TEST_F(LauncherTest, SignalsToThisProcessAreHeard) {
  Launcher launcher;
  EXPECT_EQ(launcher.interrupted_by(), 0);
  raise(SIGTERM);
  ASSERT_TRUE(readable(launcher));
  launcher.poll();
  EXPECT_EQ(launcher.interrupted_by(), SIGTERM);
}

class ExecutableTest : public LauncherTest {
 protected:
  scene::Scene scene_;
  scene::ParticipantSpec participant_;
  void SetUp() override {
    LauncherTest::SetUp();
    scene_.path = folder_ + "/scene.toml";
    participant_.name = "mine";
  }
  std::string refusal() {
    try {
      (void)find_executable(scene_, participant_);
    } catch (const ParticipantError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(ExecutableTest, RelativeToTheSceneOrInPath) {
  std::ofstream(folder_ + "/solver.sh") << "#!/bin/sh\n";
  participant_.executable = "./solver.sh";
  EXPECT_THAT(refusal(),
              AllOf(HasSubstr("'mine'"), HasSubstr(folder_ + "/solver.sh"), HasSubstr("may not be executed")));
  fs::permissions(folder_ + "/solver.sh", fs::perms::owner_all);
  EXPECT_EQ(find_executable(scene_, participant_), folder_ + "/solver.sh");
  participant_.executable = "sh";
  EXPECT_THAT(find_executable(scene_, participant_), testing::EndsWith("/sh"));
}

TEST_F(ExecutableTest, MissingProgramsAreNamedWithAdvice) {
  participant_.executable = "bin/none";
  EXPECT_THAT(refusal(), AllOf(HasSubstr(folder_ + "/bin/none does not exist"), HasSubstr("folder of the scene file")));
  participant_.executable = "bin/" + std::string(300, 'n');  // no file can be named so
  EXPECT_THAT(refusal(), HasSubstr("nnn does not exist"));
  participant_.executable = "no-such-program-anywhere";
  EXPECT_THAT(refusal(), HasSubstr("in no folder of PATH"));
}

TEST_F(ExecutableTest, WhatLaunchesAProgramIsFoundInPathToo) {
  EXPECT_TRUE(launch_prefix(scene_, participant_).empty());
  participant_.launch = {"env", "A=b"};
  EXPECT_THAT(launch_prefix(scene_, participant_), testing::ElementsAre(testing::EndsWith("/env"), "A=b"));
  for (const auto& [program, words] : {std::pair{"no-such-program-anywhere", "is in no folder of PATH"},
                                       {"/no/such/program", "does not exist or may not be executed"}}) {
    participant_.launch = {program};
    try {
      (void)launch_prefix(scene_, participant_);
      FAIL() << program;
    } catch (const ParticipantError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("'mine'"), HasSubstr(program), HasSubstr(words)));
    }
  }
}

TEST_F(ExecutableTest, SlurmLaunchesInAnAllocationOnly) {
  scene_.coupling.launcher = scene::LaunchedBy::slurm;
  unsetenv("SLURM_JOB_ID");
  try {
    (void)launch_prefix(scene_, participant_);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("coupling.launcher: found \"slurm\" outside an allocation"),
                                    HasSubstr("ricochet slurm-script " + scene_.path)));
  }
  setenv("SLURM_JOB_ID", "1", 1);
  participant_.launch = {"env"};
  EXPECT_THAT(launch_prefix(scene_, participant_), testing::ElementsAre(testing::EndsWith("/env")));
  const std::string path = std::getenv("PATH");
  std::ofstream(folder_ + "/srun") << "#!/bin/sh\n";
  fs::permissions(folder_ + "/srun", fs::perms::owner_all);
  setenv("PATH", folder_.c_str(), 1);
  participant_.launch.clear();
  participant_.threads = 3;
  EXPECT_THAT(
      launch_prefix(scene_, participant_),
      testing::ElementsAre(folder_ + "/srun", "--exact", "--mem=0", "--nodes=1", "--ntasks=1", "--cpus-per-task=3"));
  participant_.ranks = 4;
  EXPECT_THAT(
      launch_prefix(scene_, participant_),
      testing::ElementsAre(folder_ + "/srun", "--exact", "--mem=0", "--mpi=pmix", "--ntasks=4", "--cpus-per-task=3"));
  setenv("PATH", path.c_str(), 1);
  unsetenv("SLURM_JOB_ID");
}

TEST_F(ExecutableTest, RanksAreStartedByMpirun) {
  participant_.role = scene::Role::explicit_solver;
  participant_.ranks = 4;
  EXPECT_EQ(shipped_program(participant_), "explicit_solver_mpi");
  const auto words = launch_prefix(scene_, participant_);
  EXPECT_THAT(words.front(), testing::EndsWith("/mpirun"));
  EXPECT_THAT(words, testing::Contains("4"));
  EXPECT_EQ(std::count(words.begin(), words.end(), "--allow-run-as-root"), geteuid() == 0 ? 1 : 0);
}

}  // namespace
}  // namespace ricochet::coupler
