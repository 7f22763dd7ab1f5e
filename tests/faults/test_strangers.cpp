// Who has no key of the run: whatever they send, the run goes on and nothing of it is taken.
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

/// The most main memory that the process has had so far [bytes].
double peak_memory(pid_t pid) {
  const std::string text = proc_text("/proc/" + std::to_string(pid) + "/status");
  const auto at = text.find("VmHWM:");
  return at == std::string::npos ? 0.0 : 1024.0 * std::stod(text.substr(at + 6));
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

/// Connections by the hundred per second to a run that computes: it takes about as long, and a death is noticed at
/// once.
TEST(Flood, of_connections_neither_slows_a_run_nor_hides_a_death) {
  const TemporaryFolder folder;
  FaultRun run(folder, with_key(bars(all_windows), "coupling", "transport", "\"tcp\""));
  ASSERT_NO_FATAL_FAILURE(run.reach(500));
  const std::string command = proc_text("/proc/" + std::to_string(run.pid_of("explicit")) + "/cmdline");
  const std::string option = "--connect";
  std::string endpoint = command.substr(command.find(option) + option.size() + 1);
  endpoint = endpoint.substr(0, endpoint.find('\0'));
  std::atomic<bool> over = false;
  std::thread flood([&] {
    while (!over) Connection(endpoint).say("\xff\0\0\0\0\0\0\0\1\x7f");
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(run.pid_of("explicit"), SIGKILL);
  expect_failure(run, 4, "participant_failed", {"participant 'explicit' was killed by signal 9 (SIGKILL) in window "},
                 3.0);
  over = true;
  flood.join();
}

}  // namespace
}  // namespace ricochet::test
