// Participants started by hand: those the scene waits for, and strangers who are turned away while the run goes on.
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

const std::string tcp = "\ntransport = \"tcp\"\n", by_hand = "start = \"by_hand\"";

std::string over_tcp(const std::string& scene) { return replaced(scene, "[coupling]\n", "[coupling]" + tcp); }

/// A participant in the background, as a user would start it.
class ByHand {
 public:
  ByHand(const TemporaryFolder& folder, const std::string& solver, const std::string& scene, const std::string& name,
         const std::vector<std::string>& offered)
      : error_(folder.path().string() + "/by_hand_" + name + ".txt"),
        process_(command(solver, scene, name, offered), "/dev/null", error_) {}
  int wait(double timeout_s) { return process_.wait(timeout_s); }
  [[nodiscard]] pid_t pid() const { return process_.pid(); }
  [[nodiscard]] std::string error_text() const { return file_text(error_); }

 private:
  static std::vector<std::string> command(const std::string& solver, const std::string& scene, const std::string& name,
                                          const std::vector<std::string>& offered) {
    std::vector<std::string> words = {program(solver), "--scene", scene, "--name", name};
    words.insert(words.end(), offered.begin(), offered.end());
    return words;
  }
  std::string error_;
  Process process_;
};

/// The words that the coupler says the user shall type behind the name: --connect ENDPOINT --key FILE.
std::vector<std::string> offered(FaultRun& run) {
  const std::string option = "--connect ";
  wait_until([&] { return run.error_text().find(option) != std::string::npos || !run.coupler().running(); }, 10.0);
  const std::string text = run.error_text();
  const auto begin = text.find(option);
  if (begin == std::string::npos) throw std::runtime_error("no endpoint offered: " + text);
  std::istringstream line(text.substr(begin, text.find('\n', begin) - begin));
  return {std::istream_iterator<std::string>(line), {}};
}

TEST(StartedByHand, late_but_in_time_over_tcp) {
  const TemporaryFolder folder;
  FaultRun run(folder, over_tcp(with_participants(bars(few_windows, 10.0), "explicit", "", by_hand)));
  const auto endpoint = offered(run);
  EXPECT_THAT(endpoint[1], testing::StartsWith("tcp://127.0.0.1:"));
  namespace fs = std::filesystem;
  EXPECT_EQ(fs::status(endpoint[3]).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_THAT(run.error_text(), HasSubstr("participant 'implicit' is to be started by hand, within 10 s"));
  static_cast<void>(run.pid_of("explicit"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  ByHand implicit(folder, "implicit_solver", run.scene(), "implicit", endpoint);
  EXPECT_EQ(run.coupler().wait(20.0), 0) << run.error_text();
  EXPECT_EQ(implicit.wait(2.0), 0) << implicit.error_text();
  EXPECT_FALSE(fs::exists(endpoint[3])) << "the key is of this run alone";
  expect_recovery(run, folder);
}

TEST(StartedByHand, before_the_coupler_listens) {
  const TemporaryFolder folder;
  const std::string text = over_tcp(with_participants(bars(few_windows, 10.0), "explicit", "", by_hand));
  std::vector<std::string> endpoint;
  {
    FaultRun first(folder, text);  // finds out a free port; its participants must not disturb the next run there
    endpoint = offered(first);
  }
  const std::string port = endpoint[1].substr(endpoint[1].rfind(':') + 1);
  EXPECT_TRUE(std::filesystem::remove(endpoint[3])) << "who is killed while it waits leaves a key";
  const std::string with_port = replaced(text, tcp, tcp + "port = " + port + "\n");
  ByHand implicit(folder, "implicit_solver", folder.write(with_port, "by_hand.toml"), "implicit", endpoint);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  FaultRun run(folder, with_port);
  EXPECT_EQ(run.coupler().wait(20.0), 0) << run.error_text();
  EXPECT_EQ(implicit.wait(2.0), 0) << implicit.error_text();
}

TEST(StartedByHand, never_comes) {
  const TemporaryFolder folder;
  FaultRun run(folder, over_tcp(with_participants(bars(few_windows, 1.5), "explicit", "", by_hand)));
  expect_failure(run, 4, "participant_failed", {"participant 'implicit' has not said hello within 1.5 s"});
  expect_recovery(run, folder);
}

class StartedByHandOver : public testing::TestWithParam<const char*> {};

/// Its connection closes at once; the timeout of 60 s plays no part.
TEST_P(StartedByHandOver, killed_is_told_as_gone_at_once) {
  const TemporaryFolder folder;
  std::string scene = with_participants(bars(all_windows), "explicit", "", by_hand);
  scene = with_key(scene, "coupling", "transport", std::string("\"") + GetParam() + "\"");
  FaultRun run(folder, scene);
  ByHand implicit(folder, "implicit_solver", run.scene(), "implicit", offered(run));
  ASSERT_NO_FATAL_FAILURE(run.reach(1000));
  kill(implicit.pid(), SIGKILL);
  expect_failure(run, 4, "participant_failed",
                 {"participant 'implicit' is gone in window ", "its connection was closed"});
  expect_recovery(run, folder);
}

TEST_P(StartedByHandOver, ends_at_once_when_the_coupler_is_killed) {
  const TemporaryFolder folder;
  std::string scene = with_participants(bars(all_windows), "explicit", "", by_hand);
  scene = with_key(scene, "coupling", "transport", std::string("\"") + GetParam() + "\"");
  FaultRun run(folder, scene);
  ByHand implicit(folder, "implicit_solver", run.scene(), "implicit", offered(run));
  ASSERT_NO_FATAL_FAILURE(run.reach(1000));
  kill(run.coupler().pid(), SIGKILL);
  EXPECT_EQ(implicit.wait(5.0), 4) << implicit.error_text();
  EXPECT_THAT(implicit.error_text(), HasSubstr("the coupler is gone"));
  expect_recovery(run, folder);
}

INSTANTIATE_TEST_SUITE_P(Faults, StartedByHandOver, testing::Values("shm", "zmq", "tcp"),
                         [](const auto& test) { return test.param; });

TEST(StartedByHand, coupler_not_there) {
  const TemporaryFolder folder;
  const std::string scene = folder.write(bars(few_windows, 1.0));
  ByHand implicit(folder, "implicit_solver", scene, "implicit", {"--connect", "ipc://@ricochet-nobody"});
  EXPECT_EQ(implicit.wait(5.0), 4);
  EXPECT_THAT(implicit.error_text(), HasSubstr("the coupler has not answered within 1 s"));
}

/// Somebody who comes while a run waits for its implicit participant.
struct Stranger {
  const char* what;
  const char* name;
  const char* scene_role;  ///< in the stranger's own scene
  std::vector<std::string> words;
};

void PrintTo(const Stranger& stranger, std::ostream* out) { *out << stranger.what; }

const std::vector<Stranger> strangers = {
    {"unknown_name",
     "implict",
     "implicit",
     {"this run has no participant 'implict', allowed are explicit, implicit", "did you mean"}},
    {"another_scene", "implicit", "implicit", {"participant 'implicit' read another scene", "give both the same file"}},
    {"wrong_role", "implicit", "explicit", {"participant 'implicit' says it is explicit, the scene wants implicit"}},
    {"name_of_another",
     "explicit",
     "",
     {"participant 'implicit' says it is 'explicit': it has the key of the one, not of the other"}},
};

class Strangers : public testing::TestWithParam<Stranger> {
 protected:
  [[nodiscard]] std::string scene_of_the_stranger() const {
    const auto& stranger = GetParam();
    const std::string role = stranger.scene_role, name = stranger.name;
    if (role.empty()) return run_.scene();
    const std::string explicit_name = role == "explicit" ? name : "explicit";
    const std::string implicit_name = role == "implicit" ? name : "other";
    const std::string text = with_participants(bars(few_windows, 9.0), explicit_name, "");
    const std::string after = "\nrole = \"implicit\"";
    return folder_.write(replaced(text, "name = \"implicit\"" + after, "name = \"" + implicit_name + "\"" + after),
                         "stranger.toml");
  }
  void be_turned_away(const std::vector<std::string>& endpoint) const {
    const bool is_explicit = GetParam().scene_role != std::string("implicit");
    ByHand stranger(folder_, is_explicit ? "explicit_solver" : "implicit_solver", scene_of_the_stranger(),
                    GetParam().name, endpoint);
    EXPECT_EQ(stranger.wait(5.0), 2) << stranger.error_text();
    for (const auto& word : GetParam().words) EXPECT_THAT(stranger.error_text(), HasSubstr(word));
  }
  const TemporaryFolder folder_;
  FaultRun run_{folder_, with_participants(bars(few_windows, 10.0), "explicit", "", by_hand)};
};

TEST_P(Strangers, are_turned_away_and_the_run_goes_on) {
  const auto endpoint = offered(run_);
  static_cast<void>(run_.pid_of("explicit"));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // 'explicit' takes part by now
  be_turned_away(endpoint);
  ByHand implicit(folder_, "implicit_solver", run_.scene(), "implicit", endpoint);
  EXPECT_EQ(run_.coupler().wait(20.0), 0) << run_.error_text();
  EXPECT_EQ(implicit.wait(2.0), 0) << implicit.error_text();
  expect_recovery(run_, folder_);
}

INSTANTIATE_TEST_SUITE_P(Faults, Strangers, testing::ValuesIn(strangers),
                         [](const auto& test) { return test.param.what; });

/// Everybody is there: the door is closed, with the right key, too.
TEST(StrangersAmongTheRun, second_participant_of_a_name_while_windows_are_computed) {
  const TemporaryFolder folder;
  FaultRun run(folder, over_tcp(with_participants(bars(all_windows / 2), "explicit", "", by_hand)));
  auto endpoint = offered(run);
  const std::string copy = folder.write(file_text(endpoint[3]), "copy.key");
  ByHand implicit(folder, "implicit_solver", run.scene(), "implicit", endpoint);
  ASSERT_NO_FATAL_FAILURE(run.reach(1000));
  EXPECT_FALSE(std::filesystem::exists(endpoint[3])) << "a key lies there for no longer than it is needed";
  endpoint[3] = copy;
  ByHand second(folder, "implicit_solver", run.scene(), "implicit", endpoint);
  EXPECT_EQ(second.wait(5.0), 4);
  EXPECT_THAT(second.error_text(), HasSubstr("or has all its participants"));
  EXPECT_TRUE(run.coupler().running()) << "the newcomer came too late for this test";
  EXPECT_EQ(run.coupler().wait(30.0), 0) << run.error_text();
  expect_recovery(run, folder);
}

/// A stranger that was turned away and does not come again is named when the run gives up waiting.
TEST(StrangersAmongTheRun, a_refusal_is_told_when_nobody_else_comes) {
  const TemporaryFolder folder;
  FaultRun run(folder, with_participants(bars(few_windows, 2.0), "explicit", "", by_hand));
  const std::string other = folder.write(bars(few_windows, 9.0), "stranger.toml");
  ByHand stranger(folder, "implicit_solver", other, "implicit", offered(run));
  expect_failure(run, 4, "participant_failed",
                 {"participant 'implicit' has not said hello within 2 s", "turned away", "read another scene"});
  EXPECT_EQ(stranger.wait(2.0), 2);
}

}  // namespace
}  // namespace ricochet::test
