// Killed at random windows, gone on from the last checkpoint: in the end the bytes are those of an undisturbed run.
#include <fmt/format.h>

#include <map>
#include <random>

#include "tests/faults/fault_run.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

constexpr int every_windows = 10;

/// A scene for each protocol, with laws and transports among them; each run takes some tenths of a second.
std::vector<std::string> scenes() {
  const std::string flight = with_key(config_text("two_bars"), "time", "end_s", "5e-3");
  const auto over = [](const std::string& text, const std::string& transport) {
    return with_key(text, "coupling", "transport", "\"" + transport + "\"");
  };
  const std::string impact = with_key(config_text("kim_impact"), "output", "axial_stress_every", "10");
  std::vector<std::string> texts = {
      over(impact, "shm"),
      over(with_protocol(flight, "kim"), "zmq"),
      over(with_protocol(flight, "fixed_point"), "tcp"),
      over(with_key(impact, "contact", "multiplier_update", "\"massless\""), "tcp"),
      with_protocol_of_two_steps(flight, "prakash_hjelmstad"),
      with_protocol(config_text("slipping_plates"), "belytschko_mullen"),
      with_protocol(impact, "all_implicit"),
      over(with_protocol(impact, "all_explicit"), "zmq"),
      with_key(with_protocol(flight, "gravouil_combescure"), "coupling", "substeps", "2"),
      with_protocol(impact, "kim_predicted"),
  };
  for (auto& text : texts) {
    text = with_key(text, "output", "fields_every", "100");
    text = with_key(text, "checkpoint", "every_windows", std::to_string(every_windows));
  }
  return texts;
}

enum class Victim { explicit_solver, implicit_solver, coupler, everything, power };

struct Kills {
  const char* name;
  Victim victim;
};

void PrintTo(const Kills& kills, std::ostream* out) { *out << kills.name; }

/// Runs, and goes on with, scenes that are killed again and again.
class Resumed : public testing::TestWithParam<Kills> {
 protected:
  static constexpr int wanted = 24, most_of_a_run = 5;

  /// How long an undisturbed run takes [s], and its results.
  struct Whole {
    std::string folder;
    double wall_s = 0.0;
  };
  const Whole& whole(std::size_t scene) {
    auto& found = wholes_[scene];
    if (found.folder.empty()) {
      const auto run = run_file(path_of(scene), folder_, fmt::format("whole{}", scene));
      EXPECT_EQ(run.outcome.code, 0) << run.outcome.error;
      found = {run.folder, run.summary.at("wall_s")};
    }
    return found;
  }
  std::string path_of(std::size_t scene) {
    const auto name = fmt::format("scene{}.toml", scene);
    if (!std::filesystem::exists(folder_.path() / name)) static_cast<void>(folder_.write(texts_[scene], name));
    return (folder_.path() / name).string();
  }
  [[nodiscard]] std::vector<pid_t> participants(const std::string& scene, const std::string& name) const {
    return processes_with("--scene " + scene + " --name " + name);
  }
  void kill_victims(Process& run, const std::string& scene) {
    const auto victim = GetParam().victim;
    std::vector<pid_t> victims;
    if (victim == Victim::explicit_solver) victims = participants(scene, "explicit");
    if (victim == Victim::implicit_solver) victims = participants(scene, "implicit");
    if (victim == Victim::everything || victim == Victim::power) victims = participants(scene, "");
    if (victims.empty() || victim >= Victim::coupler) victims.push_back(run.pid());  // a baseline has but one of them
    for (const pid_t pid : victims) kill(pid, SIGKILL);
  }
  std::vector<std::string> command(const std::string& scene, const std::string& out, bool again) const {
    std::vector<std::string> words;
    if (GetParam().victim == Victim::power) {
      words = {"/usr/bin/env", "LD_PRELOAD=" + program("libpower_cut.so"), "POWER_CUT_FOLDER=" + out,
               "POWER_CUT_DISK=" + disk()};
    }
    words.push_back(ricochet_binary());
    words.insert(words.end(), again ? std::initializer_list<std::string>{"resume", out}
                                    : std::initializer_list<std::string>{"run", scene, "--out", out});
    return words;
  }
  [[nodiscard]] std::string disk() const { return (folder_.path() / "disk").string(); }
  /// Only what was synchronised is there.
  void lose_what_was_not_synchronised(const std::string& out) {
    int last = 0;
    for (const auto& name : names_in(folder_.path().string())) {
      if (name.starts_with("disk.") && !name.ends_with(".half")) last = std::max(last, std::stoi(name.substr(5)));
    }
    std::filesystem::remove_all(out);
    if (last > 0) std::filesystem::rename(fmt::format("{}.{}", disk(), last), out);
    forget_disks();
  }
  void forget_disks() {
    for (const auto& name : names_in(folder_.path().string())) {
      if (name.starts_with("disk.")) std::filesystem::remove_all(folder_.path() / name);
    }
  }

  TemporaryFolder folder_;
  std::vector<std::string> texts_ = scenes();
  std::map<std::size_t, Whole> wholes_;
  std::mt19937 random_{20261123};
};

TEST_P(Resumed, AfterEveryKill) {
  int kills = 0, runs = 0, resumed = 0;
  for (; kills < wanted; ++runs) {
    const std::size_t scene = static_cast<std::size_t>(runs) % texts_.size();
    const auto& undisturbed = whole(scene);
    const auto path = path_of(scene), out = (folder_.path() / fmt::format("out{}", runs)).string();
    for (int here = 0;; ++here) {
      const bool again = !checkpoints_in(out).empty();
      resumed += again ? 1 : 0;
      Process run(command(path, out, again), folder_.path() / "o", folder_.path() / "e");
      if (here < most_of_a_run) {
        std::uniform_real_distribution<> moment(0.0, undisturbed.wall_s + 0.05);
        run.wait(moment(random_));
      }
      if (here == most_of_a_run || !run.running()) {
        ASSERT_EQ(run.wait(60.0), 0) << file_text(folder_.path() / "e");
        break;
      }
      kill_victims(run, path);
      ++kills;
      const int code = run.wait(20.0);
      EXPECT_THAT(code, testing::AnyOf(0, 4, 137)) << file_text(folder_.path() / "e");
      ASSERT_TRUE(wait_until([&] { return participants(path, "").empty(); }, 10.0)) << "processes are left";
      if (GetParam().victim == Victim::power) lose_what_was_not_synchronised(out);
    }
    ASSERT_NO_FATAL_FAILURE(expect_same_results(out, undisturbed.folder)) << "scene " << scene;
    if (HasFailure()) FAIL() << "scene " << scene << " after " << kills << " kills in all";
    std::filesystem::remove_all(out);
    forget_disks();
  }
  fmt::print("{} kills of {} survived, in {} runs; gone on from a checkpoint {} times\n", kills, GetParam().name, runs,
             resumed);
  EXPECT_GT(resumed, kills / 4);
}

INSTANTIATE_TEST_SUITE_P(Kills, Resumed,
                         testing::Values(Kills{"the_explicit_solver", Victim::explicit_solver},
                                         Kills{"the_implicit_solver", Victim::implicit_solver},
                                         Kills{"the_coupler", Victim::coupler},
                                         Kills{"all_processes", Victim::everything}, Kills{"the_power", Victim::power}),
                         [](const auto& test) { return test.param.name; });

/// Kills participants of a run, one after the other, each when there is a further checkpoint and the run goes on.
void kill_each_in_turn(const std::vector<std::string>& names, const std::string& scene, const std::string& out,
                       const std::string& errors) {
  for (std::size_t killed = 0; killed < names.size(); ++killed) {
    const auto before = checkpoints_in(out);
    ASSERT_TRUE(wait_until([&] { return checkpoints_in(out) != before && !checkpoints_in(out).empty(); }, 20.0));
    std::vector<pid_t> found;
    ASSERT_TRUE(wait_until(
        [&] { return !(found = processes_with("--scene " + scene + " --name " + names[killed])).empty(); }, 20.0));
    kill(found.front(), SIGKILL);
    const auto words = fmt::format("(attempt {} of 10)", killed + 1);
    ASSERT_TRUE(wait_until([&] { return file_text(errors).find(words) != std::string::npos; }, 20.0))
        << file_text(errors);
  }
}

/// Ten times a participant is killed, and nobody does anything about it.
TEST(ResumedByItself, ThroughTenKills) {
  const TemporaryFolder folder;
  constexpr int windows = 10 * all_windows;  // so many that ten kills come in between
  const std::string flight = with_key(apart(bars(windows)), "output", "fields_every", std::to_string(all_windows));
  const std::string text = with_key(
      with_key(with_key(flight, "checkpoint", "every_windows", "1000"), "checkpoint", "on_failure", "\"resume\""),
      "checkpoint", "attempts", "10");
  const RunResult whole = run_text(text, folder, "whole");
  const auto scene = (folder.path() / "whole.toml").string(), out = (folder.path() / "out").string();
  Process run({ricochet_binary(), "run", scene, "--out", out}, folder.path() / "o", folder.path() / "e");
  std::vector<std::string> names;
  for (int killed = 0; killed < 10; ++killed) names.emplace_back(killed % 2 == 0 ? "explicit" : "implicit");
  ASSERT_NO_FATAL_FAILURE(kill_each_in_turn(names, scene, out, (folder.path() / "e").string()));
  EXPECT_EQ(run.wait(60.0), 0) << file_text(folder.path() / "e");
  expect_same_results(out, whole.folder);
}

/// The sizes of windows after the checkpoint are forgotten with these windows: WindowClock::change drops them.
TEST(ResumedByItself, InAFlightOfLongWindows) {
  const TemporaryFolder folder;
  std::string text =
      replaced(config_text("bouncing_bar"), "safety_factor = 0.9\n", "step_s = 9e-7\nflight_step_s = 9e-6\n");
  text = with_key(with_key(text, "checkpoint", "every_windows", "2000"), "checkpoint", "on_failure", "\"resume\"");
  const RunResult whole = run_text(text, folder, "whole");
  const auto scene = (folder.path() / "whole.toml").string(), out = (folder.path() / "out").string();
  Process run({ricochet_binary(), "run", scene, "--out", out}, folder.path() / "o", folder.path() / "e");
  ASSERT_NO_FATAL_FAILURE(
      kill_each_in_turn({"explicit", "explicit", "explicit"}, scene, out, (folder.path() / "e").string()));
  EXPECT_EQ(run.wait(60.0), 0) << file_text(folder.path() / "e");
  expect_same_results(out, whole.folder);
}

TEST(ResumedByItself, NoMoreOftenThanAllowed) {
  const TemporaryFolder folder;
  const std::string text = with_participants(
      with_key(with_key(bars(few_windows), "checkpoint", "on_failure", "\"resume\""), "checkpoint", "attempts", "3"),
      "explicit", "executable = \"/bin/false\"");
  const auto run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(run.outcome.error, HasSubstr("(attempt 3 of 3)"));
  EXPECT_THAT(run.outcome.error, testing::Not(HasSubstr("(attempt 4")));
}

/// The folder of the checkpoints is full; the run itself is not.
TEST(CheckpointOnAFullDisk, IsToldOfAndTheRunGoesOn) {
  const TemporaryFolder folder;
  const auto out = (folder.path() / "out").string();
  const std::string mount = "mount -t tmpfs -o size=8k none '" + out + "/checkpoint'";
  std::filesystem::create_directories(out + "/checkpoint");
  if (run_command({"/usr/bin/unshare", "-rm", "sh", "-c", mount}, folder.path().string()).code != 0) {
    GTEST_SKIP() << "no user namespaces here";
  }
  const auto scene = folder.write(with_key(bars(few_windows), "checkpoint", "every_windows", "100"));
  const std::string line = mount + " && '" + ricochet_binary() + "' run '" + scene + "' --out '" + out +
                           "'; code=$?; ls '" + out + "/checkpoint'; exit $code";
  const auto outcome = run_command({"/usr/bin/unshare", "-rm", "sh", "-c", line}, folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("warning: no checkpoint at window 100: cannot write"));
  EXPECT_THAT(outcome.error, HasSubstr("No space left on device (errno 28)"));
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr(".state"))) << "halves are left";
}

}  // namespace
}  // namespace ricochet::test
