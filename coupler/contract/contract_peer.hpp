#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/lifecycle.hpp"
#include "coupler/processes/process_set.hpp"

namespace ricochet::coupler {

/// A program to be tested: with --connect ENDPOINT appended it is to behave as a participant.
struct ContractCommand {
  std::vector<std::string> words;
  double timeout_s = 10.0;  ///< longest wait for each answer, and for an end
};

/// One process under test and the coupler's end of its conversation, closely watched. The process is stopped with this
/// object. Everything throws ParticipantError if the process ends or is silent, ProtocolError for what breaks the
/// protocol, the participant's own error if it says `failure`, and Interrupted after Ctrl-C.
class ContractPeer {
 public:
  explicit ContractPeer(const ContractCommand& command);
  ContractPeer(const ContractPeer&) = delete;
  ContractPeer& operator=(const ContractPeer&) = delete;
  ~ContractPeer();

  /// Waits for `hello`.
  const wire::Hello& meet();
  /// Lets it take part under this name, in this version of the wire protocol, which may be a wrong one.
  void welcome(const std::string& name, double timeout_s, std::int64_t version = wire::protocol_version);
  /// Sends `message`, of which the rest of the header is filled in here, and waits for the answer, which lives until
  /// the next one.
  const wire::Message& ask(wire::Message& message);
  /// The next message; unlike `ask` it hands over a `failure`, too. Null if the process ended without one.
  const wire::Message* hear();
  /// A coupler that dies: the connection is gone, the process' standard input stays open.
  void die() { set_.hang_up(); }
  /// How the process ended; nothing if it still runs after the timeout.
  std::optional<ProcessEnd> wait_end();
  /// The last lines it printed, for error texts.
  [[nodiscard]] std::string log_tail() const;

 private:
  void tell(wire::Message& message, std::int64_t version);
  [[noreturn]] void throw_ended(const std::string& when);
  std::string run_id_;
  double timeout_s_;
  std::filesystem::path log_;
  ProcessSet set_;
  wire::Lifecycle lifecycle_;
  wire::Message inbox_;
  std::string identity_;
  std::int64_t sequence_ = 0;
};

}  // namespace ricochet::coupler
