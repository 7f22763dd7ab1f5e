#pragma once

#include <string>

/// Says who may talk: key pairs made for one run (CURVE of ZeroMQ; texts of 40 characters, Z85).
namespace ricochet::wire {

struct KeyPair {
  std::string public_key, secret_key;
};

/// Throws MachineError if this ZeroMQ was built without CURVE.
[[nodiscard]] KeyPair make_key_pair();

/// The secrets that a participant must know to talk to its coupler, and to be known by it.
struct ParticipantKey {
  std::string coupler_public_key;
  KeyPair own;
};

/// As it is handed over: three lines "coupler KEY", "public KEY", "secret KEY".
[[nodiscard]] std::string to_text(const ParticipantKey& key);
/// Waits for the file: the run that makes the key may begin later than the participant. Throws ConfigError naming the
/// file if it cannot be read, is not there within `timeout_s`, or holds something else.
[[nodiscard]] ParticipantKey read_key(const std::string& path, double timeout_s);

}  // namespace ricochet::wire
