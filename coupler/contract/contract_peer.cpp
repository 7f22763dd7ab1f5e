#include "coupler/contract/contract_peer.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "coupler/processes/interrupted.hpp"
#include "coupler/processes/run_id.hpp"

namespace ricochet::coupler {
namespace {

constexpr const char* participant = "under test";  // its name for launcher and error texts
constexpr std::size_t shown_lines = 4;

Member member_of(const ContractCommand& command, const std::string& log) {
  Member member;
  member.name = participant;
  member.executable = command.words.front();
  member.arguments.assign(command.words.begin() + 1, command.words.end());
  member.log_path = log;
  return member;
}

}  // namespace

ContractPeer::ContractPeer(const ContractCommand& command)
    : run_id_(make_run_id()),
      timeout_s_(command.timeout_s),
      log_(std::filesystem::temp_directory_path() / ("ricochet-check-" + run_id_ + ".log")),
      set_({member_of(command, log_)}, {run_id_, "", timeout_s_}, "ipc://*") {
  set_.launch();
}

ContractPeer::~ContractPeer() {
  set_.launcher().stop(std::chrono::milliseconds(500));
  std::error_code ignored;
  std::filesystem::remove(log_, ignored);
}

const wire::Hello& ContractPeer::meet() {
  if (!hear()) throw_ended("before it said hello");
  if (inbox_.kind == wire::Kind::failure)
    throw ParticipantError("it failed at start: " + inbox_.as<wire::Failure>().error_text);
  set_.listener().limit(identity_, wire::default_largest_message);
  return inbox_.as<wire::Hello>();
}

void ContractPeer::welcome(const std::string& name, double timeout_s, std::int64_t version) {
  wire::Message message;
  auto& welcome = message.make<wire::Welcome>();
  welcome.participant = name;
  welcome.timeout_s = timeout_s;
  tell(message, version);
}

void ContractPeer::tell(wire::Message& message, std::int64_t version) {
  message.version = version;
  message.run_id = run_id_;
  message.sequence = sequence_++;
  lifecycle_.step(wire::Side::coupler, message, participant);
  set_.listener().send(identity_, message);
}

const wire::Message& ContractPeer::ask(wire::Message& message) {
  tell(message, wire::protocol_version);
  if (!hear()) throw_ended(fmt::format("asked to '{}'", wire::name(message.kind)));
  if (inbox_.kind == wire::Kind::failure) {
    throw ParticipantError(
        fmt::format("asked to '{}' it failed: {}", wire::name(message.kind), inbox_.as<wire::Failure>().error_text));
  }
  if (inbox_.run_id != run_id_) throw ProtocolError("it sent a message of another run");
  return inbox_;
}

const wire::Message* ContractPeer::hear() {
  auto& launcher = set_.launcher();
  const auto deadline = wire::deadline_in(timeout_s_);
  const auto nothing_happened = [&launcher](std::size_t) {
    launcher.poll();
    return launcher.events() == 0;
  };
  for (;;) {
    launcher.poll();
    const bool ended = launcher.end_of(participant).has_value();
    if (set_.listener().receive(identity_, inbox_, ended ? wire::deadline_in(drain_s) : deadline,
                                {launcher.file_descriptor()}, nothing_happened)) {
      break;
    }
    if (launcher.interrupted_by() != 0) throw Interrupted(launcher.interrupted_by());
    if (ended) return nullptr;
    if (wire::Clock::now() < deadline) continue;
    throw ParticipantError(fmt::format("it was silent for {} s while {}", timeout_s_, lifecycle_.state()));
  }
  lifecycle_.step(wire::Side::participant, inbox_, participant);
  return &inbox_;
}

std::optional<ProcessEnd> ContractPeer::wait_end() {
  set_.launcher().wait_all(std::chrono::milliseconds(static_cast<long>(1000 * timeout_s_)));
  if (set_.launcher().interrupted_by() != 0) throw Interrupted(set_.launcher().interrupted_by());
  return set_.launcher().end_of(participant);
}

std::string ContractPeer::log_tail() const {
  auto lines = last_lines(log_, shown_lines);
  while (!lines.empty() && lines.back() == '\n') lines.pop_back();
  return lines.empty() ? "" : "; it printed\n" + lines;
}

void ContractPeer::throw_ended(const std::string& when) {
  const auto end = set_.launcher().end_of(participant)->text();
  throw ParticipantError(fmt::format("{} it {}{}", when, end, log_tail()));
}

}  // namespace ricochet::coupler
