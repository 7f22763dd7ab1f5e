#include "tests/cluster/hosts.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "tests/support/process.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::test {
namespace {

int open_card(const std::string& name) {
  const int end = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  ifreq request{};
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  std::strncpy(request.ifr_name, name.c_str(), IFNAMSIZ - 1);
  if (end < 0 || ioctl(end, TUNSETIFF, &request) != 0)
    throw std::runtime_error(fmt::format("no tap device {}: {}", name, std::strerror(errno)));
  return end;
}

/// Names that no other process of this machine uses.
std::string card(int host) { return fmt::format("ric{}-{}", getpid(), host); }

Outcome ip(const std::vector<std::string>& words) {
  const TemporaryFolder scratch;
  std::vector<std::string> command = {"/usr/sbin/ip"};
  command.insert(command.end(), words.begin(), words.end());
  return run_command(command, scratch.path().string(), 10.0);
}

void require_ip(const std::vector<std::string>& words) {
  if (const auto outcome = ip(words); outcome.code != 0)
    throw std::runtime_error(fmt::format("ip {}: {}", fmt::join(words, " "), outcome.error));
}

}  // namespace

Cable::Cable(const std::string& card, const std::string& other_card) {
  ends_[0] = open_card(card);
  ends_[1] = open_card(other_card);
  carrier_ = std::jthread([this](const std::stop_token& stop) { carry(stop); });
}

Cable::~Cable() {
  carrier_ = {};
  for (const int end : ends_) close(end);
}

void Cable::worsen(std::chrono::microseconds delay, double loss) {
  delay_us_ = delay.count();
  loss_ = loss;
}

void Cable::carry(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    pollfd waits[2] = {{ends_[0], POLLIN, 0}, {ends_[1], POLLIN, 0}};
    const auto longest = std::chrono::nanoseconds(std::chrono::milliseconds(50));
    const auto left = under_way_.empty() ? longest : std::chrono::nanoseconds(under_way_.front().due - Clock::now());
    const timespec timeout{0, std::clamp<long>(left.count(), 0, longest.count())};
    ppoll(waits, 2, &timeout, nullptr);
    for (int end = 0; end < 2; ++end) {
      if (waits[end].revents != 0) take(end);
    }
    deliver();
  }
}

void Cable::take(int from) {
  char bytes[65536];
  for (ssize_t size; (size = read(ends_[from], bytes, sizeof(bytes))) > 0;) {
    if (cut_ || std::uniform_real_distribution<>()(random_) < loss_) {
      ++lost_;
      continue;
    }
    under_way_.push_back({Clock::now() + std::chrono::microseconds(delay_us_), from, {bytes, bytes + size}});
  }
}

void Cable::deliver() {
  while (!under_way_.empty() && under_way_.front().due <= Clock::now()) {
    const auto& frame = under_way_.front();
    if (!cut_ && write(ends_[1 - frame.from], frame.bytes.data(), frame.bytes.size()) > 0) ++carried_;
    under_way_.pop_front();
  }
}

std::string TwoHosts::obstacle() {
  if (geteuid() != 0) return "network namespaces need root";
  if (access("/usr/sbin/ip", X_OK) != 0) return "/usr/sbin/ip is missing: apt-get install iproute2";
  if (access("/dev/net/tun", R_OK | W_OK) != 0) return "this kernel has no tap devices";
  const std::string trial = fmt::format("trial-{}", getpid());
  if (const auto outcome = ip({"netns", "add", trial}); outcome.code != 0)
    return "no network namespaces here: " + outcome.error;
  ip({"netns", "delete", trial});
  return "";
}

TwoHosts::TwoHosts() : cable_(card(0), card(1)) {
  for (int host = 0; host < 2; ++host) {
    require_ip({"netns", "add", name(host)});
    require_ip({"link", "set", card(host), "netns", name(host)});
    require_ip({"-n", name(host), "address", "add", address(host) + "/24", "dev", card(host)});
    require_ip({"-n", name(host), "link", "set", card(host), "up"});
    require_ip({"-n", name(host), "link", "set", "lo", "up"});
  }
}

TwoHosts::~TwoHosts() {
  for (int host = 0; host < 2; ++host) ip({"netns", "delete", name(host)});
}

std::string TwoHosts::name(int host) const { return fmt::format("host{}-{}", host, getpid()); }

std::string TwoHosts::address(int host) { return fmt::format("10.77.0.{}", host + 1); }

std::vector<std::string> TwoHosts::on(int host) const {
  // A name of its own, too, by which errors call it.
  return {"/usr/sbin/ip",
          "netns",
          "exec",
          name(host),
          "/usr/bin/unshare",
          "--uts",
          "/bin/sh",
          "-c",
          "hostname " + name(host) + " && exec \"$0\" \"$@\""};
}

}  // namespace ricochet::test
