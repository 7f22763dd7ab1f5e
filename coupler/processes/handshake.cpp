// The part of Peers that meets participants: who is let in, who is turned away and with what words.
#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/base/process.hpp"
#include "coupler/processes/peers.hpp"

namespace ricochet::coupler {
namespace {

using wire::Clock;

/// In which a process that was killed is known to have ended.
constexpr std::chrono::milliseconds until_seen{300};

}  // namespace

void Peers::handshake() {
  const auto begin = Clock::now();
  const auto deadline =
      begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(run_.start_wait_s()));
  const auto missing = [this] {
    return std::find_if(peers_.begin(), peers_.end(),
                        [](const Remote& peer) { return peer.identity.empty() && !peer.inside; });
  };
  while (missing() != peers_.end()) {
    if (receive_one(deadline, "")) continue;
    const auto& peer = *missing();
    throw ParticipantError(fmt::format("participant '{}' has not said hello within {} s (coupling.start_timeout_s){}{}",
                                       peer.expected.name, run_.start_wait_s(), refusal_text(peer), log_tail(peer)));
  }
  listener_.close_door();
}

/// A message from someone who is not (yet) a peer.
void Peers::admit() {
  const int config = static_cast<int>(ExitCode::config);
  const int protocol = static_cast<int>(ExitCode::protocol);
  if (scratch_->kind == wire::Kind::failure) return;
  if (scratch_->kind != wire::Kind::hello) {
    refuse(fmt::format("the first message must be 'hello', not '{}'", wire::name(scratch_->kind)), protocol);
    return;
  }
  std::vector<std::string> names;
  for (const auto& peer : peers_) names.push_back(peer.expected.name);
  const auto& hello = scratch_->as<wire::Hello>();
  const auto found = std::find(names.begin(), names.end(), hello.participant);
  if (found == names.end()) {
    refuse(fmt::format("this run has no participant '{}', allowed are {}{}", hello.participant, fmt::join(names, ", "),
                       did_you_mean(hello.participant, names)),
           config);
    return;
  }
  auto& peer = peers_[static_cast<std::size_t>(found - names.begin())];
  std::string objection = objection_to_hello(hello, peer);
  const bool may_take_part = objection.empty();
  auto memory = may_take_part ? open_shared_memory(hello, objection) : nullptr;
  if (!objection.empty()) {
    const bool launched_here =
        peer.identity.empty() && launcher_.launched(*found) && listener_.sender() == peer.expected.name;
    // Its memory goes with it, where it was killed since it said hello.
    if (may_take_part && launched_here && launcher_.wait_for(*found, until_seen)) {
      peer.process_id = hello.process_id;
      check_end(peer);
    }
    refuse(objection, config);
    if (peer.identity.empty()) peer.refusal = objection;
    if (launched_here) throw ConfigError(objection);  // no second one will come
    return;
  }
  peer.lifecycle.step(wire::Side::participant, *scratch_, peer.expected.name);
  peer.identity = scratch_identity_;
  peer.process_id = hello.process_id;
  if (hello.machine != machine_name()) peer.machine = hello.machine;
  peer.last_heard = Clock::now();
  wire::Message message;
  auto& welcome = message.make<wire::Welcome>();
  welcome.participant = peer.expected.name;
  // The coupler may wait for one peer after another while this one has nothing to do.
  welcome.timeout_s = 2.0 * std::max(run_.timeout_s, run_.start_wait_s());
  welcome.shared_memory = memory != nullptr;
  peer.transport = memory ? Transport::shm : run_.transport == Transport::tcp ? Transport::tcp : Transport::zmq;
  post(peer, message);
  peer.busy = false;
  listener_.limit(peer.identity, run_.largest_message);
  if (memory) listener_.share(peer.identity, std::move(memory));
}

/// Why who said hello as `peer` must not take part; empty if nothing speaks against it.
std::string Peers::objection_to_hello(const wire::Hello& hello, const Remote& peer) const {
  const auto& name = peer.expected.name;
  if (!listener_.sender().empty() && listener_.sender() != name) {
    return fmt::format("participant '{}' says it is '{}': it has the key of the one, not of the other",
                       listener_.sender(), name);
  }
  if (!peer.identity.empty() || peer.inside) {
    return fmt::format("participant '{}' already takes part in this run (process {})", name, peer.process_id);
  }
  if (hello.role != name_of(peer.expected.role)) {
    return fmt::format("participant '{}' says it is {}, the scene wants {}", name, hello.role,
                       name_of(peer.expected.role));
  }
  if (!hello.scene_sha256.empty() && hello.scene_sha256 != run_.scene_sha256) {
    return fmt::format(
        "participant '{}' read another scene (SHA-256 {:.12}..., this run has {:.12}...); give both the "
        "same file",
        name, hello.scene_sha256, run_.scene_sha256);
  }
  return "";
}

/// The memory that the hello offers, if the scene lets it be used. With transport "auto" ZeroMQ takes its place where
/// it cannot be had; with "shm" that is an objection.
std::unique_ptr<wire::SharedMemory> Peers::open_shared_memory(const wire::Hello& hello, std::string& objection) const {
  const bool required = run_.transport == Transport::shm;
  if (!required && run_.transport != Transport::automatic) return nullptr;
  std::string why = "it offers no shared memory";
  if (!hello.shared_memory_path.empty()) {
    try {
      return wire::SharedMemory::open(hello.shared_memory_path, hello.shared_memory_key);
    } catch (const ConfigError& error) {
      why = error.what();
    }
  }
  if (required) {
    objection = fmt::format("{}: found \"shm\", which participant '{}' cannot have: {}; \"auto\" allows ZeroMQ for it",
                            run_.transport_where, hello.participant, why);
  }
  return nullptr;
}

void Peers::refuse(const std::string& text, int code) {
  last_refusal_ = text;
  wire::Message message;
  message.run_id = run_.run_id;
  auto& failure = message.make<wire::Failure>();
  failure.error_code = code;
  failure.error_text = text;
  failure.error_culprit = scratch_->kind == wire::Kind::hello ? scratch_->as<wire::Hello>().participant : "";
  listener_.send(scratch_identity_, message);
}

}  // namespace ricochet::coupler
