// Strangers without a key of the run: whatever they send, the run goes on and nothing of it is taken.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <atomic>
#include <deque>
#include <thread>
#include <zmq.hpp>

#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

/// Two participants, one of which is started by hand, so that the door stays open.
std::string waiting_for_one(const std::string& transport) {
  const std::string text = with_participants(bars(few_windows, 20.0), "explicit", "", "start = \"by_hand\"");
  return with_key(text, "coupling", "transport", "\"" + transport + "\"");
}

std::vector<std::string> offered(FaultRun& run) {
  const std::string option = "--connect ";
  wait_until([&] { return run.error_text().find(option) != std::string::npos || !run.coupler().running(); }, 10.0);
  const std::string text = run.error_text();
  const auto begin = text.find(option);
  if (begin == std::string::npos) throw std::runtime_error("no endpoint offered: " + text);
  std::istringstream line(text.substr(begin, text.find('\n', begin) - begin));
  return {std::istream_iterator<std::string>(line), {}};
}

class Stranger : public testing::TestWithParam<const char*> {
 protected:
  /// The participant that everybody waits for comes, and all ends well.
  void expect_good_end() {
    const auto peak = peak_memory(run_.coupler().pid());
    EXPECT_LT(peak, 500e6) << "the coupler took memory for strangers";
    auto words = std::vector<std::string>{program("implicit_solver"), "--scene", run_.scene(), "--name", "implicit"};
    words.insert(words.end(), offered_.begin(), offered_.end());
    Process implicit(words, "/dev/null", folder_.path().string() + "/implicit.txt");
    EXPECT_EQ(run_.coupler().wait(60.0), 0) << run_.error_text();
    EXPECT_EQ(implicit.wait(5.0), 0);
    EXPECT_EQ(run_.summary().at("status"), "done");
  }
  [[nodiscard]] const std::string& endpoint() const { return offered_[1]; }

  const TemporaryFolder folder_;
  FaultRun run_{folder_, waiting_for_one(GetParam())};
  const std::vector<std::string> offered_ = offered(run_);
};

TEST_P(Stranger, without_a_key_says_what_it_likes) {
  zmq::context_t context;
  std::vector<zmq::socket_t> sockets;
  for (int i = 0; i < 50; ++i) {
    auto& socket = sockets.emplace_back(context, zmq::socket_type::dealer);
    socket.set(zmq::sockopt::linger, 0);
    // The names that ZeroMQ gives begin with a zero; one that is taken already brought the whole process down.
    if (i % 2 == 1) socket.set(zmq::sockopt::routing_id, std::string("explicit"));
    socket.connect(endpoint());
    for (int k = 0; k < 20; ++k) {
      static_cast<void>(socket.send(zmq::str_buffer("\x81\xa4kind\xa5hello"), zmq::send_flags::dontwait));
      static_cast<void>(socket.send(zmq::str_buffer("more"), zmq::send_flags::sndmore | zmq::send_flags::dontwait));
      static_cast<void>(socket.send(zmq::str_buffer("and more"), zmq::send_flags::dontwait));
    }
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  expect_good_end();
}

/// With the right address, key of the coupler and mechanism, but a pair of keys of its own.
TEST_P(Stranger, with_a_key_of_its_own_is_shut_out) {
  const auto path = offered_[3];
  std::istringstream key(file_text(path));
  std::string word, coupler;
  key >> word >> coupler;
  char public_key[41], secret_key[41];
  ASSERT_EQ(zmq_curve_keypair(public_key, secret_key), 0);
  const std::string other =
      folder_.write("coupler " + coupler + "\npublic " + public_key + "\nsecret " + secret_key + "\n", "other.key");
  Process stranger({program("implicit_solver"), "--scene", run_.scene(), "--name", "implicit", "--connect", endpoint(),
                    "--key", other},
                   "/dev/null", folder_.path().string() + "/stranger.txt");
  EXPECT_EQ(stranger.wait(10.0), 4);
  EXPECT_THAT(file_text(folder_.path().string() + "/stranger.txt"), HasSubstr("it does not know this key"));
  expect_good_end();
}

INSTANTIATE_TEST_SUITE_P(Faults, Stranger, testing::Values("zmq", "tcp"), [](const auto& test) { return test.param; });

class Connection {
 public:
  explicit Connection(const std::string& endpoint) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1))));
    connected_ = connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { close(socket_); }
  [[nodiscard]] bool connected() const { return connected_; }
  /// False as soon as the other end has closed.
  bool say(const std::string& bytes) const {
    return send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }

 private:
  int socket_;
  bool connected_ = false;
};

class StrangerOverTcp : public Stranger {};

TEST_P(StrangerOverTcp, with_a_thousand_idle_connections_takes_no_descriptors) {
  std::deque<Connection> idle;
  for (int i = 0; i < 1500; ++i) {
    idle.emplace_back(endpoint());
    if (!idle.back().connected()) idle.pop_back();  // this process has its limits, too
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const auto files = "/proc/" + std::to_string(run_.coupler().pid()) + "/fd";
  EXPECT_LT(std::distance(std::filesystem::directory_iterator(files), {}), 256);
  expect_good_end();
}

/// The greeting of ZeroMQ 3.0 with the mechanism CURVE, then a command that never ends.
TEST_P(StrangerOverTcp, with_an_endless_greeting_takes_no_memory) {
  std::string greeting = std::string("\xff\0\0\0\0\0\0\0\1\x7f\3\0CURVE", 17);
  greeting.resize(64, '\0');
  const std::string command("\x06\0\0\0\1\0\0\0\0", 9), rubbish(1 << 20, 'x');
  for (int i = 0; i < 10; ++i) {
    const Connection connection(endpoint());
    if (!connection.say(greeting + command)) continue;
    for (int k = 0; k < 300 && connection.say(rubbish); ++k) {
    }
  }
  expect_good_end();
}

INSTANTIATE_TEST_SUITE_P(Faults, StrangerOverTcp, testing::Values("tcp"), [](const auto& test) { return test.param; });

/// `check` and `run` say so where strangers of other machines can come; where only this machine can, they do not.
TEST(Address, that_the_world_can_reach_is_warned_of) {
  const std::string warning = "found \"0.0.0.0\", which other machines can reach";
  for (const std::string address : {"0.0.0.0", "127.0.0.1"}) {
    const TemporaryFolder folder;
    const auto tcp = with_key(bars(few_windows), "coupling", "transport", "\"tcp\"");
    const auto scene = folder.write(with_key(tcp, "coupling", "address", "\"" + address + "\""));
    const auto check = run_command({ricochet_binary(), "check", scene}, folder.path().string(), 60.0);
    const auto run = run_file(scene, folder);
    EXPECT_EQ(check.code, 0) << check.error;
    EXPECT_EQ(run.outcome.code, 0) << run.outcome.error;
    const bool told = address != "127.0.0.1";
    EXPECT_EQ(check.out.find(warning) != std::string::npos, told) << check.out;
    EXPECT_EQ(run.outcome.error.find(warning) != std::string::npos, told) << run.outcome.error;
  }
}

/// Connections as fast as they can be opened, from a thread of their own, to the port of a run that computes.
class Flood : public testing::Test {
 protected:
  Flood() {
    run_.reach(500);
    const std::string command = proc_text("/proc/" + std::to_string(run_.pid_of("explicit")) + "/cmdline");
    const std::string option = "--connect";
    const std::string endpoint = command.substr(command.find(option) + option.size() + 1);
    flood_ = std::thread([this, endpoint = endpoint.substr(0, endpoint.find('\0'))] {
      while (!over_) Connection(endpoint).say("\xff\0\0\0\0\0\0\0\1\x7f");
    });
  }
  ~Flood() override {
    over_ = true;
    flood_.join();
  }

  const TemporaryFolder folder_;
  FaultRun run_{folder_, with_key(bars(all_windows), "coupling", "transport", "\"tcp\"")};
  std::atomic<bool> over_ = false;
  std::thread flood_;
};

/// A death is noticed at once, the timeout of 60 s plays no part.
TEST_F(Flood, hides_no_death) {
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(run_.pid_of("explicit"), SIGKILL);
  expect_failure(run_, 4, "participant_failed", {"participant 'explicit' was killed by signal 9 (SIGKILL) in window "},
                 30.0);
}

/// The last words of a participant are heard, though strangers get the number of its connection when it ends.
TEST_F(Flood, swallows_no_last_words) {
  EXPECT_EQ(run_.coupler().wait(60.0), 0) << run_.error_text();
  EXPECT_EQ(run_.summary().at("status"), "done");
}

}  // namespace
}  // namespace ricochet::test
