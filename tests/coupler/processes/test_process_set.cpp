// A set of processes: programs that are shell scripts, and participants that are threads of this program and come by
// hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <thread>

#include "common/base/error.hpp"
#include "coupler/processes/process_set.hpp"
#include "coupler/processes/run_id.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using wire::Kind;
using wire::Message;

class ProcessSetTest : public testing::Test {
 protected:
  const std::string folder_ = testing::TempDir() + "process_set_" + std::to_string(getpid());
  const std::string key_ = folder_ + "/keys/spring.key";
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] Member script(const std::string& name, const std::string& text) const {
    return {name, Role::explicit_solver, "/bin/sh", {"-c", text, "sh"}, folder_ + "/" + name + ".log"};
  }
  [[nodiscard]] Member by_hand() const { return {"spring", Role::explicit_solver, "spring", {}, "", key_}; }
  static RunIdentity run() { return {make_run_id(), "", 10.0}; }
  static std::string failure(const std::function<void()>& action) {
    try {
      action();
    } catch (const ParticipantError& error) {
      return error.what();
    }
    return "";
  }
};

/// Says hello with the key of the file and describes itself; `critical_time_step_s` as given.
void take_part(const std::string& endpoint, const std::string& key, double critical_time_step_s) {
  wire::Channel channel(endpoint, wire::read_key(key, 10.0));
  Message message;
  message.kind = Kind::hello;
  message.as<wire::Hello>().participant = "spring";
  message.as<wire::Hello>().role = "explicit";
  channel.send(message);
  Message heard;
  channel.receive(heard, wire::deadline_in(10.0), false);
  channel.receive(heard, wire::deadline_in(10.0), false);
  message.kind = Kind::description;
  message.run_id = heard.run_id;
  message.sequence = 1;
  message.as<wire::Description>().critical_time_step_s = critical_time_step_s;
  channel.send(message);
}

TEST_F(ProcessSetTest, TellsAProgramWhereToConnectAndItsKey) {
  ProcessSet set({script("spring", "echo \"$@\"; cat \"$4\"")}, run(), "ipc://*");
  set.launch();
  ASSERT_TRUE(set.launcher().wait_all(std::chrono::milliseconds(10000)));
  EXPECT_THAT(last_lines(set.launcher().log_path("spring"), 9),
              AllOf(HasSubstr("--connect " + set.listener().endpoint() + " --key /dev/fd/3"), HasSubstr("coupler "),
                    HasSubstr("public "), HasSubstr("secret ")));
}

TEST_F(ProcessSetTest, AProgramThatAnotherOneStartsFindsItsKeyInAFile) {
  auto member = script("spring", "echo \"$@\"; cat \"$4\"");
  member.key_file = key_;
  ProcessSet set({member}, run(), "ipc://*");
  set.launch();
  ASSERT_TRUE(set.launcher().wait_all(std::chrono::milliseconds(10000)));
  EXPECT_EQ(fs::status(key_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_THAT(last_lines(set.launcher().log_path("spring"), 9),
              AllOf(HasSubstr(" --key " + key_), HasSubstr("secret ")));
}

TEST_F(ProcessSetTest, WhoComesByHandFindsItsKeyUntilEverybodyIsThere) {
  ProcessSet set({by_hand()}, run(), "ipc://*");
  set.launch();
  EXPECT_EQ(fs::status(key_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  std::jthread spring(take_part, set.listener().endpoint(), key_, 0.5);
  set.meet();
  EXPECT_FALSE(fs::exists(folder_ + "/keys"));
  const auto descriptions = set.describe();
  ASSERT_EQ(descriptions.size(), 1U);
  EXPECT_EQ(descriptions[0].participant, "spring");
  EXPECT_EQ(descriptions[0].role, Role::explicit_solver);
  EXPECT_EQ(descriptions[0].critical_time_step_s, 0.5);
  set.check_exit_codes();  // nobody was launched, so nobody is waited for
}

TEST_F(ProcessSetTest, RefusesADescriptionThatCannotBe) {
  ProcessSet set({by_hand()}, run(), "ipc://*");
  set.launch();
  std::jthread spring(take_part, set.listener().endpoint(), key_, -1.0);
  set.meet();
  EXPECT_THROW(static_cast<void>(set.describe()), ProtocolError);
}

TEST_F(ProcessSetTest, LeavesNoKeyWhenNobodyComes) {
  {
    ProcessSet set({by_hand()}, run(), "ipc://*");
    set.launch();
    EXPECT_TRUE(fs::exists(key_));
  }
  EXPECT_FALSE(fs::exists(folder_ + "/keys"));
}

TEST_F(ProcessSetTest, NamesWhoEndedWithAnExitCode) {
  ProcessSet set({script("good", "exit 0"), script("bad", "exit 3")}, run(), "ipc://*");
  set.launch();
  EXPECT_THAT(failure([&] { set.check_exit_codes(); }),
              AllOf(HasSubstr("'bad' finished its work but ended with exit code 3"), HasSubstr("bad.log")));
}

TEST_F(ProcessSetTest, EndsWhoStillRunsWhenTheRunFails) {
  ProcessSet set({script("sleeper", "exec sleep 100")}, run(), "ipc://*");
  set.launch();
  set.fail(4, "another one died");
  ASSERT_TRUE(set.launcher().end_of("sleeper"));
  EXPECT_EQ(set.launcher().end_of("sleeper")->signal, SIGTERM);
}

}  // namespace
}  // namespace ricochet::coupler
