#include "coupler/processes/run_id.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <random>

namespace ricochet::coupler {
namespace {

std::string with_host(const std::string& bound, const std::string& host) {
  for (const std::string any : {"tcp://0.0.0.0:", "tcp://*:", "tcp://[::]:"}) {
    if (bound.rfind(any, 0) == 0) return "tcp://" + host + ":" + bound.substr(any.size());
  }
  return bound;
}

}  // namespace

std::string make_run_id() {
  std::random_device random;
  const auto now = std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now());
  return fmt::format("{:%Y%m%d-%H%M%S}-{}-{:08x}", fmt::gmtime(now), getpid(), random());
}

std::string listen_endpoint(const scene::CouplingSettings& coupling) {
  if (coupling.transport != Transport::tcp) return "ipc://*";
  const bool bare_ipv6 = coupling.address.find(':') != std::string::npos && coupling.address.front() != '[';
  return fmt::format("tcp://{}:{}", bare_ipv6 ? "[" + coupling.address + "]" : coupling.address,
                     coupling.port > 0 ? std::to_string(coupling.port) : "*");
}

std::string local_endpoint(const std::string& bound) { return with_host(bound, "127.0.0.1"); }

std::string remote_endpoint(const std::string& bound) {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) return bound;
  return with_host(bound, host.data());
}

}  // namespace ricochet::coupler
