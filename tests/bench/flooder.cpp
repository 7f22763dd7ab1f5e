#include "tests/bench/flooder.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>

#include "common/base/error.hpp"

namespace ricochet::bench {
namespace {

constexpr std::size_t most_open = 16;  // connections of the flooder at a time; the oldest one is broken off

sockaddr_in on_this_machine(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

/// The words of strangers: no greeting, half a greeting, and a greeting with a frame of 2^40 bytes behind it.
std::array<std::string, 3> rubbish() {
  std::string greeting("\xff\0\0\0\0\0\0\0\1\x7f\3\0", 12);
  greeting += std::string("NULL") + std::string(48, '\0');
  const std::string frame("\2\0\0\1\0\0\0\0\0", 9);
  return {std::string(1 << 16, '\x5a'), greeting.substr(0, 20), greeting + frame + std::string(1 << 20, '\1')};
}

/// Breaking off leaves no connection that waits for late packets, of which the machine has room for 28 000.
void break_off(int connection) {
  const linger none{1, 0};
  setsockopt(connection, SOL_SOCKET, SO_LINGER, &none, sizeof none);
  close(connection);
}

[[noreturn]] void flood(std::uint16_t port) {
  const auto address = on_this_machine(port);
  const auto words = rubbish();
  std::array<int, most_open> open{};
  open.fill(-1);
  for (std::size_t i = 0;; ++i) {
    int& connection = open[i % most_open];
    if (connection >= 0) break_off(connection);
    connection = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    if (connection < 0) continue;
    static_cast<void>(
        connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address));  // does not wait
    const auto& text = words[i % words.size()];
    static_cast<void>(send(connection, text.data(), text.size(), MSG_NOSIGNAL));
  }
}

/// A listening socket at a port that the kernel chooses.
int listen_anywhere(std::uint16_t& port) {
  const int listening = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  auto address = on_this_machine(0);
  socklen_t size = sizeof address;
  const auto generic = reinterpret_cast<sockaddr*>(&address);
  if (listening < 0 || bind(listening, generic, size) != 0 || listen(listening, 100) != 0 ||
      getsockname(listening, generic, &size) != 0) {
    throw ParticipantError("cannot listen at any port");
  }
  port = ntohs(address.sin_port);
  return listening;
}

}  // namespace

Flooder::Flooder(std::uint16_t port) : pid_(fork()) {
  if (pid_ < 0) throw ParticipantError("cannot start another process");
  if (pid_ > 0) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a flood must not outlive a benchmark that is interrupted
  flood(port);
}

Flooder::~Flooder() {
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

OtherPort::OtherPort() : listening_(listen_anywhere(number_)) {}

OtherPort::~OtherPort() { close(listening_); }

std::uint16_t free_port() {
  std::uint16_t port = 0;
  close(listen_anywhere(port));
  return port;
}

}  // namespace ricochet::bench
