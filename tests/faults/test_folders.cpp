// Things in a folder of results and around a run: halves, names, FIFOs, locks, sockets of who was killed, early
// signals.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <random>

#include "tests/faults/fault_run.hpp"
#include "tests/support/places.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Not;

Outcome ricochet(const TemporaryFolder& folder, std::vector<std::string> words, double timeout_s = 60.0) {
  words.insert(words.begin(), ricochet_binary());
  return run_command(words, folder.path().string(), timeout_s);
}

std::string that_mends_itself(const std::string& text, int every_windows) {
  return with_key(with_key(with_key(text, "checkpoint", "every_windows", std::to_string(every_windows)), "checkpoint",
                           "on_failure", "\"resume\""),
                  "checkpoint", "attempts", "50");
}

/// The half of a field that a killed participant leaves is not taken for somebody's.
TEST(DeathDuringAField, IsMended) {
  const TemporaryFolder folder;
  const auto text = that_mends_itself(apart(bars(all_windows)), few_windows);
  const RunResult whole = run_file(folder.write(text), folder, "whole");
  ASSERT_EQ(whole.outcome.code, 0) << whole.outcome.error;
  FaultRun run(folder, text);
  ASSERT_NO_FATAL_FAILURE(run.reach(fields_every));
  std::ofstream(fmt::format("{}/fields/explicit.left_{:08}.vtu.part", run.out(), all_windows)) << "half of a";
  kill(run.pid_of("explicit"), SIGKILL);
  EXPECT_EQ(run.coupler().wait(120.0), 0) << run.error_text();
  EXPECT_THAT(run.error_text(), HasSubstr("warning: going on from window "));
  expect_whole_files(run.out());
  expect_same_results(run.out(), whole.folder);
}

/// With a field after every window most kills come while one is being written.
TEST(DeathDuringAField, IsMendedWheneverItComes) {
  const TemporaryFolder folder;
  const auto text = that_mends_itself(with_key(apart(bars(few_windows)), "output", "fields_every", "1"), 100);
  const RunResult whole = run_file(folder.write(text), folder, "whole");
  ASSERT_EQ(whole.outcome.code, 0) << whole.outcome.error;
  std::mt19937 random{27};
  int kills = 0, halves = 0;
  for (int runs = 0; runs < 4; ++runs) {
    FaultRun run(folder, text);
    while (run.coupler().running() && kills < 4 * (runs + 1)) {
      std::uniform_real_distribution<> moment(0.0, 0.2);
      run.coupler().wait(moment(random));
      const auto victims =
          processes_with("--scene " + run.scene() + " --name " + (kills % 2 == 0 ? "explicit " : "implicit "));
      if (victims.empty()) continue;
      kill(victims.front(), SIGKILL);
      ++kills;
      for (const auto& name : names_in(run.out() + "/fields")) halves += name.ends_with(".part") ? 1 : 0;
    }
    ASSERT_EQ(run.coupler().wait(120.0), 0) << run.error_text();
    expect_whole_files(run.out());
    expect_same_results(run.out(), whole.folder);
    fs::remove_all(run.out());
  }
  fmt::print("{} kills, {} halves of fields seen after them\n", kills, halves);
}

/// As ricochet names what it writes for it.
TEST(Names, ThatNoFileCanHaveAreRefusedBeforeTheRun) {
  const TemporaryFolder folder;
  const std::string name(252, 'n');
  const auto scene = folder.write(with_participants(bars(few_windows), name, ""));
  const auto participant = ricochet(folder, {"run", scene, "--out", (folder.path() / "out").string()});
  EXPECT_EQ(participant.code, 2) << participant.error;
  EXPECT_THAT(participant.error, AllOf(HasSubstr(name + ".log"), HasSubstr("bytes"), HasSubstr("allowed are 255")));
  EXPECT_FALSE(fs::exists(folder.path() / "out/summary.json"));
  const auto long_scene = folder.write(bars(few_windows), std::string(247, 's') + ".toml");
  const auto outcome = ricochet(folder, {"run", long_scene, "--out", (folder.path() / "out").string()});
  EXPECT_EQ(outcome.code, 2) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("_#.vtm: found a name of 270 bytes ('#': 18 digits), allowed are 255"));
}

TEST(Names, OfAFieldOfAWindowThatNoRunHasIsNamedAndStays) {
  const TemporaryFolder folder;
  const auto scene = folder.write(with_key(bars(few_windows), "checkpoint", "every_windows", "300"));
  const auto run = run_file(scene, folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  const auto stray = run.folder + "/fields/explicit.left_" + std::string(25, '1') + ".vtu";
  std::ofstream(stray) << "by the user";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"run", scene, "--out", run.folder}, std::vector<std::string>{"resume", run.folder}}) {
    const auto outcome = ricochet(folder, words);
    EXPECT_EQ(outcome.code, 2) << outcome.error;
    EXPECT_THAT(outcome.error, HasSubstr(stray + " is there already, and ricochet did not write it"));
    EXPECT_EQ(file_text(stray), "by the user");
  }
}

/// Also where the list of the folder knows the names, as that of a run that was killed does.
TEST(Names, OfAFieldOfAWindowThatNoRunHasIsNamedAfterAKill) {
  const TemporaryFolder folder;
  FaultRun run(folder, with_key(bars(all_windows), "checkpoint", "every_windows", "300"));
  ASSERT_NO_FATAL_FAILURE(run.reach(few_windows));
  ASSERT_TRUE(wait_until([&] { return !checkpoints_in(run.out()).empty(); }, 20.0)) << "its disk may be slower";
  kill(run.coupler().pid(), SIGKILL);
  run.coupler().wait(10.0);
  ASSERT_TRUE(run.participants_gone(10.0));
  const auto stray = run.out() + "/fields/explicit.left_" + std::string(25, '1') + ".vtu";
  std::ofstream(stray) << "by the user";
  const auto outcome = resume(run.out(), folder);
  EXPECT_EQ(outcome.code, 2) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr(stray + " is there already, and ricochet did not write it"));
  EXPECT_EQ(file_text(stray), "by the user");
}

TEST(Names, ATabInThePathOfASceneBreaksNoList) {
  const TemporaryFolder folder;
  const auto scene = folder.write(with_key(bars(few_windows), "checkpoint", "every_windows", "300"), "a\ttab\\n.toml");
  for (int repeat = 0; repeat < 2; ++repeat) {
    const auto run = run_file(scene, folder);
    EXPECT_EQ(run.outcome.code, 0) << run.outcome.error;
    EXPECT_TRUE(fs::exists(run.folder + "/fields/a\ttab\\n.pvd"));
    EXPECT_EQ(resume(run.folder, folder).code, 0);
  }
}

/// Reading one might never end.
TEST(FifosAndDevices, InAFolderOfResultsAreRefused) {
  const TemporaryFolder folder;
  const auto scene = folder.write(with_key(bars(few_windows), "checkpoint", "every_windows", "300"));
  const auto run = run_file(scene, folder);
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.error;
  const auto window = std::to_string(checkpoints_in(run.folder).back());
  fs::remove(fmt::format("{}/checkpoint/{}.json", run.folder, checkpoints_in(run.folder).front()));
  const auto aside = (folder.path() / "aside").string();
  struct Reader {
    std::string file;
    std::vector<std::string> words;
  };
  const std::vector<Reader> readers = {
      {".ricochet-files", {"run", scene, "--out", run.folder}},
      {"history.csv", {"run", scene, "--out", run.folder}},
      {"logs/explicit.log", {"run", scene, "--out", run.folder}},
      {"checkpoint/" + window + ".json", {"resume", run.folder}},
      {"checkpoint/" + window + ".state", {"resume", run.folder}},
      {"history.csv", {"resume", run.folder}},
      {"fields/implicit.left_00000000.vtu", {"resume", run.folder}},
      {"summary.json", {"report", run.folder}},
      {"history.csv", {"report", run.folder}},
      {"trace.json", {"report", run.folder}},
      {"fields/explicit.shapes.json", {"report", run.folder}},
  };
  for (const auto& reader : readers) {
    const auto path = run.folder + "/" + reader.file;
    fs::rename(path, aside);
    for (const bool fifo : {true, false}) {
      if (fifo) {
        ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
      } else {
        fs::create_symlink("/dev/zero", path);
      }
      const auto outcome = ricochet(folder, reader.words, 10.0);
      EXPECT_EQ(outcome.code, 2) << reader.words.front() << " with " << path << ": " << outcome.error;
      EXPECT_THAT(outcome.error, HasSubstr(path));
      fs::remove(path);
    }
    fs::rename(aside, path);
  }
  EXPECT_EQ(resume(run.folder, folder).code, 0) << "all is as it was";
}

/// A run whose step is chosen keeps the name of its scene, as any other.
TEST(ChosenStep, ClaimsTheIndexOfItsFields) {
  const TemporaryFolder folder;
  const std::string text = bars(few_windows);
  const auto partition = text.find("[partition]"), time = text.find("[time]");
  const auto scene =
      folder.write(replaced(text.substr(0, partition) + "[partition]\nrule = \"auto\"\n" + text.substr(time), "step_s",
                            "largest_step_s"),
                   "mine.toml");
  fs::create_directories(folder.path() / "out/fields");
  const auto index = folder.write("by the user", "out/fields/mine.pvd");
  const auto outcome = ricochet(folder, {"run", scene, "--out", (folder.path() / "out").string()});
  EXPECT_EQ(outcome.code, 2) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr(index + " is there already, and ricochet did not write it"));
  EXPECT_EQ(file_text(index), "by the user");
}

/// A process of another kind, maybe of another user, that holds the lock of a folder.
class Locker {
 public:
  Locker(const std::string& folder, uid_t user) : pid_(fork()) {
    if (pid_ != 0) return;
    if (user != geteuid() && setuid(user) != 0) _exit(1);
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY);
    if (flock(descriptor, LOCK_SH) != 0) _exit(1);
    std::ofstream(folder + ".locked") << "yes";
    for (;;) pause();
  }
  Locker(const Locker&) = delete;
  Locker& operator=(const Locker&) = delete;
  ~Locker() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_;
};

class LockOfAnother : public testing::TestWithParam<bool> {};

TEST_P(LockOfAnother, is_said_to_be_what_it_is) {
  constexpr uid_t nobody = 65534;
  const bool another_user = GetParam();
  if (another_user && geteuid() != 0) GTEST_SKIP() << "only root may become another user";
  const TemporaryFolder folder;
  fs::permissions(folder.path(), fs::perms::all);
  const auto out = (folder.path() / "out").string();
  fs::create_directories(out);
  const auto scene = folder.write(bars(few_windows));
  const Locker locker(out, another_user ? nobody : geteuid());
  ASSERT_TRUE(wait_until([&] { return fs::exists(out + ".locked"); }, 10.0));
  const auto run = ricochet(folder, {"run", scene, "--out", out});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.error,
              AllOf(HasSubstr(fmt::format("process {} ('test_faults') of user '", locker.pid())),
                    HasSubstr("which is no run of yours, holds the lock of " + out),
                    HasSubstr("give this one its own folder with --out DIR"), Not(HasSubstr("another run"))));
  EXPECT_EQ(run.error.find("of user 'nobody'") != std::string::npos, another_user) << run.error;
  const auto asked = ricochet(folder, {"checkpoint", out}, 10.0);
  EXPECT_EQ(asked.code, 2);
  EXPECT_THAT(asked.error, HasSubstr("no run is writing into " + out + ": process "));
}

INSTANTIATE_TEST_SUITE_P(Faults, LockOfAnother, testing::Bool(),
                         [](const auto& test) { return test.param ? "user" : "program"; });

/// A coupler that is killed while its participants come leaves the folder of its socket; nobody else's is touched.
TEST(AbandonedSockets, AreRemovedByTheNextRun) {
  const TemporaryFolder folder;
  const auto runtime = (folder.path() / "runtime").string();
  fs::create_directories(runtime + "/ricochet-1-abcdef");  // of a process that lives
  fs::create_directories(runtime + "/ricochet-notes");
  const auto silent = folder.write("#!/bin/sh\nexec sleep 30\n", "silent.sh");
  fs::permissions(silent, fs::perms::owner_all);
  const auto waiting =
      folder.write(with_participants(bars(few_windows), "explicit", "executable = \"./silent.sh\""), "waiting.toml");
  const auto out = (folder.path() / "out").string();
  const auto env = "XDG_RUNTIME_DIR=" + runtime;
  std::string left;
  {
    Process run({"/usr/bin/env", env, ricochet_binary(), "run", waiting, "--out", out}, folder.path() / "o",
                folder.path() / "e");
    left = fmt::format("ricochet-{}-", run.pid());
    ASSERT_TRUE(
        wait_until([&] { return names_in(runtime).size() == 3U && fs::exists(out + "/logs/explicit.log"); }, 20.0));
    kill(run.pid(), SIGKILL);
    run.wait(10.0);
  }
  ASSERT_THAT(names_in(runtime), testing::Contains(testing::StartsWith(left)));
  const auto outcome =
      run_command({"/usr/bin/env", env, ricochet_binary(), "run", folder.write(bars(few_windows)), "--out", out},
                  folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(names_in(runtime), testing::UnorderedElementsAre("ricochet-1-abcdef", "ricochet-notes"));
}

/// A request for a checkpoint that comes before anybody hears it.
TEST(RequestsBeforeTheRun, AreAnsweredAsSoonAsItCanBe) {
  const TemporaryFolder folder;
  const auto scene = folder.write(bars(few_windows)), out = (folder.path() / "out").string();
  // The signal waits in this process when it becomes the program.
  const std::string python =
      "import os, signal, sys\nsignal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR1})\n"
      "os.kill(os.getpid(), signal.SIGUSR1)\nos.execv(sys.argv[1], sys.argv[1:])\n";
  const auto outcome = run_command({"/usr/bin/python3", "-c", python, ricochet_binary(), "run", scene, "--out", out},
                                   folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_EQ(checkpoints_in(out).size(), 1U);
}

/// While ./ricochet builds, and when its process has become the program, which is not loaded yet.
TEST(RequestsBeforeTheRun, DoNotEndTheCommandThatStartsIt) {
  const TemporaryFolder folder;
  const auto write_program = [&](const std::string& name, const std::string& text) {
    fs::permissions(folder.write("#!/bin/sh\n" + text, name), fs::perms::owner_all);
  };
  fs::create_directories(folder.path() / "build");
  static_cast<void>(folder.write("", "build/build.ninja"));
  write_program("ninja", "kill -USR1 $PPID\n");
  write_program("dpkg-query", "echo ok installed\n");
  write_program("build/ricochet", "kill -USR1 $$\nexec " + ricochet_binary() + " \"$@\"\n");
  const auto scene = folder.write(bars(few_windows)), out = (folder.path() / "out").string();
  const auto outcome = run_command({"/usr/bin/env", "PATH=" + folder.path().string() + ":/usr/bin:/bin",
                                    "RICOCHET_BUILD_DIR=" + (folder.path() / "build").string(),
                                    source_folder() + "/ricochet", "run", scene, "--out", out},
                                   folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_TRUE(fs::exists(out + "/summary.json"));
}

/// As ./ricochet starts it: what is ignored until then is heard.
TEST(RequestsBeforeTheRun, AreAnsweredThoughTheyWereIgnoredAtTheStart) {
  const TemporaryFolder folder;
  const auto scene = folder.write(bars(few_windows)), out = (folder.path() / "out").string();
  const std::string python =
      "import os, signal, subprocess, sys, time\nsignal.signal(signal.SIGUSR1, signal.SIG_IGN)\n"
      "run = subprocess.Popen(sys.argv[2:], restore_signals=False)\n"
      "while not os.path.exists(sys.argv[1] + '/logs'): time.sleep(0.001)\n"
      "run.send_signal(signal.SIGUSR1)\nsys.exit(run.wait())\n";
  const auto outcome = run_command(
      {"/usr/bin/python3", "-c", python, out, ricochet_binary(), "run", scene, "--out", out}, folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_EQ(checkpoints_in(out).size(), 1U);
}

}  // namespace
}  // namespace ricochet::test
