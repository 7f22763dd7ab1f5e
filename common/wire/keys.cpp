#include "common/wire/keys.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "common/base/error.hpp"

namespace ricochet::wire {
namespace {

constexpr std::size_t key_length = 40;
constexpr std::chrono::milliseconds between_looks{20};

}  // namespace

KeyPair make_key_pair() {
  std::array<char, key_length + 1> public_key{}, secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) == 0) return {public_key.data(), secret_key.data()};
  throw MachineError(
      fmt::format("cannot make a key pair: {}; ricochet needs a ZeroMQ with CURVE (libsodium)", zmq_strerror(errno)));
}

std::string to_text(const ParticipantKey& key) {
  return fmt::format("coupler {}\npublic {}\nsecret {}\n", key.coupler_public_key, key.own.public_key,
                     key.own.secret_key);
}

ParticipantKey read_key(const std::string& path, double timeout_s) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (access(path.c_str(), F_OK) != 0 && errno == ENOENT && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(between_looks);
  }
  std::ifstream file(path);
  if (!file) throw ConfigError(fmt::format("--key: cannot read {}: {}", path, std::strerror(errno)));
  ParticipantKey key;
  for (const auto& [word, value] : {std::pair{"coupler", &key.coupler_public_key},
                                    {"public", &key.own.public_key},
                                    {"secret", &key.own.secret_key}}) {
    std::string found;
    if (file >> found >> *value && found == word && value->size() == key_length) continue;
    throw ConfigError(
        fmt::format("--key: {} is no key of a run: expected the lines \"coupler KEY\", \"public KEY\", \"secret KEY\", "
                    "each KEY of {} characters",
                    path, key_length));
  }
  return key;
}

}  // namespace ricochet::wire
