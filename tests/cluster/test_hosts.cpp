// A run on two hosts with a cable between them that is slow, loses frames, is cut and restored.
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <sstream>
#include <thread>

#include "tests/cluster/hosts.hpp"
#include "tests/support/places.hpp"
#include "tests/support/process_table.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using std::chrono::microseconds;
using testing::HasSubstr;

class Hosts : public testing::Test {
 protected:
  static constexpr double timeout_s = 5.0;

  void SetUp() override {
    if (const auto obstacle = TwoHosts::obstacle(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    hosts_ = std::make_unique<TwoHosts>();
  }
  void TearDown() override {
    EXPECT_TRUE(wait_until([&] { return processes_with("--scene " + scene()).empty(); }, 5.0)) << "processes are left";
  }
  [[nodiscard]] std::string scene() const { return (folder_.path() / "scene.toml").string(); }
  [[nodiscard]] std::string out() const { return (folder_.path() / "out").string(); }
  [[nodiscard]] std::string said() const { return file_text(folder_.path() / "e"); }

  /// Computes it undisturbed on this machine first; then coupler and explicit solver are on host 0, the implicit one on
  /// host 1.
  void prepare(int windows, bool by_hand = false) {
    auto text = with_key(config_text("two_bars"), "time", "end_s", fmt::format("{}", windows * 2.226e-6));
    text = with_key(with_key(text, "checkpoint", "every_windows", "20"), "coupling", "timeout_s",
                    fmt::format("{}", timeout_s));
    text = with_key(text, "coupling", "transport", "\"tcp\"");
    history_ = file_text(run_text(text, folder_, "here").folder + "/history.csv");
    text = with_key(text, "coupling", "address", "\"" + TwoHosts::address(0) + "\"");
    std::string words;
    for (const auto& word : hosts_->on(1)) words += "'" + word + "', ";
    const auto start = by_hand ? "start = \"by_hand\"" : "launch = [" + words + "]";
    text +=
        "\n[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"left\", \"right\"]\n"
        "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n" +
        start + "\n";
    static_cast<void>(folder_.write(text));
  }
  /// `ricochet` on host 0.
  [[nodiscard]] std::unique_ptr<Process> start(const std::vector<std::string>& arguments) const {
    auto words = hosts_->on(0);
    words.push_back(ricochet_binary());
    words.insert(words.end(), arguments.begin(), arguments.end());
    return std::make_unique<Process>(words, folder_.path() / "o", folder_.path() / "e");
  }
  [[nodiscard]] std::unique_ptr<Process> run() const { return start({"run", scene(), "--out", out()}); }
  [[nodiscard]] bool wait_for_checkpoint() const {
    return wait_until([&] { return !checkpoints_in(out()).empty(); }, 30.0);
  }
  void expect_the_same_history() const {
    EXPECT_TRUE(file_text(out() + "/history.csv") == history_) << "another history";
  }

  TemporaryFolder folder_;
  std::unique_ptr<TwoHosts> hosts_;
  std::string history_;
};

TEST_F(Hosts, WithAMillisecondBetweenThemAndOneFrameInAHundredLostComputeTheSameBytes) {
  prepare(300);
  hosts_->cable().worsen(microseconds(1000), 0.01);
  const auto begin = std::chrono::steady_clock::now();
  const auto process = run();
  ASSERT_EQ(process->wait(120.0), 0) << said();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  expect_the_same_history();
  EXPECT_GT(hosts_->cable().lost(), 0);
  fmt::print("{} frames carried, {} lost, in {:.1f} s\n", hosts_->cable().carried(), hosts_->cable().lost(),
             elapsed.count());
}

TEST_F(Hosts, GoOnWhenTheCableWasCutForLessThanHalfOfTheDeadline) {
  prepare(600);
  hosts_->cable().worsen(microseconds(1000), 0.0);
  const auto process = run();
  ASSERT_TRUE(wait_for_checkpoint()) << said();
  hosts_->cable().cut();
  std::this_thread::sleep_for(std::chrono::milliseconds(static_cast<int>(1000 * 0.4 * timeout_s)));
  EXPECT_TRUE(process->running()) << said();
  hosts_->cable().restore();
  ASSERT_EQ(process->wait(60.0), 0) << said();
  expect_the_same_history();
}

/// Nobody can end it from the coupler's side of a cable that is cut.
TEST_F(Hosts, WhoWasStartedByHandOnTheFarSideOfACutEndsByItself) {
  prepare(800, true);
  hosts_->cable().worsen(microseconds(1000), 0.0);
  const auto process = run();
  const std::string option = "implicit_solver ";
  ASSERT_TRUE(wait_until([&] { return said().find("--key ") != std::string::npos; }, 10.0)) << said();
  const auto at = said().find(option) + option.size();
  std::istringstream line(said().substr(at, said().find('\n', at) - at));
  auto words = hosts_->on(1);
  words.push_back(build_folder() + "/implicit_solver");
  for (std::string word; line >> word;) words.push_back(word);
  Process implicit(words, "/dev/null", folder_.path() / "implicit");
  ASSERT_TRUE(wait_for_checkpoint()) << said();
  hosts_->cable().cut();
  ASSERT_EQ(process->wait(timeout_s + 6.0), 4) << said();
  EXPECT_THAT(said(), HasSubstr("participant 'implicit' on " + hosts_->name(1) + " has been silent for"));
  EXPECT_EQ(implicit.wait(2.0 * timeout_s), 4);
  EXPECT_THAT(file_text(folder_.path() / "implicit"), HasSubstr("the coupler has not answered within 10 s"));
}

struct Loss {
  const char* what;
  bool host_stops;
};

void PrintTo(const Loss& loss, std::ostream* out) { *out << loss.what; }

class LostHosts : public Hosts, public testing::WithParamInterface<Loss> {};

TEST_P(LostHosts, AreNamedWithinTheDeadlineAndTheRunIsGoneOnWith) {
  prepare(800);
  hosts_->cable().worsen(microseconds(1000), 0.0);
  const auto process = run();
  ASSERT_TRUE(wait_for_checkpoint()) << said();
  hosts_->cable().cut();
  if (GetParam().host_stops) {
    const auto found = processes_with("--scene " + scene() + " --name implicit ");
    ASSERT_FALSE(found.empty());
    for (const pid_t pid : found) kill(pid, SIGSTOP);
  }
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(process->wait(timeout_s + 6.0), 4) << said();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_THAT(said(),
              HasSubstr("participant 'implicit' on " + hosts_->name(1) + " has been silent for 5.0 s in window"));
  EXPECT_TRUE(wait_until([&] { return processes_with("--scene " + scene()).empty(); }, 5.0)) << "processes are left";
  fmt::print("named after {:.1f} s\n", elapsed.count());
  hosts_->cable().restore();
  const auto again = start({"resume", out()});
  ASSERT_EQ(again->wait(60.0), 0) << said();
  EXPECT_THAT(said(), HasSubstr("going on from window "));
  expect_the_same_history();
}

INSTANTIATE_TEST_SUITE_P(By, LostHosts, testing::Values(Loss{"a_cable_cut", false}, Loss{"a_host_gone", true}),
                         [](const auto& test) { return test.param.what; });

}  // namespace
}  // namespace ricochet::test
