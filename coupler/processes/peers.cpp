#include "coupler/processes/peers.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "coupler/processes/interrupted.hpp"

namespace ricochet::coupler {
namespace {

using wire::Clock;

Clock::duration seconds(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
}

double since_epoch_s(Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }

constexpr std::uintmax_t largest_log = 100'000'000;
constexpr std::chrono::milliseconds between_looks_at_logs{100}, until_told_why{1000};

}  // namespace

Peers::Peers(wire::Listener& listener, Launcher& launcher, std::vector<ExpectedPeer> expected, RunIdentity run)
    : listener_(listener), launcher_(launcher), run_(std::move(run)), descriptors_{launcher.file_descriptor()} {
  peers_.resize(expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    peers_[i].expected = std::move(expected[i]);
    peers_[i].last_heard = Clock::now();
    peers_[i].idle_while_s.assign(peers_.size(), 0.0);
  }
}

void Peers::enter(std::size_t index, std::unique_ptr<participant::Participant> participant) {
  auto& peer = peers_[index];
  peer.inside = std::make_unique<Inside>(std::move(participant));
  peer.process_id = getpid();
  wire::Message message;
  message.make<wire::Hello>();
  peer.lifecycle.step(wire::Side::participant, message, peer.expected.name);
  peer.inside->on_progress([this, index](std::string_view doing, double share_done) {
    if (on_progress_) on_progress_(name(index), doing, share_done);
  });
  auto& welcome = message.make<wire::Welcome>();
  welcome.participant = peer.expected.name;
  welcome.timeout_s = run_.timeout_s;
  post(peer, message);
  peer.inside->work(*scratch_);
  peer.busy = false;
}

Peer Peers::peer(std::size_t index) {
  return {peers_[index].expected.name, [this, index](wire::Message& message) { post(peers_[index], message); },
          [this, index]() -> wire::Message& { return wait(index); }};
}

std::vector<Peer> Peers::all() {
  std::vector<Peer> peers;
  for (std::size_t p = 0; p < peers_.size(); ++p) peers.push_back(peer(p));
  return peers;
}

void Peers::post(Remote& peer, wire::Message& message) {
  message.version = wire::protocol_version;
  message.run_id = run_.run_id;
  message.sequence = peer.sequence++;
  peer.lifecycle.step(wire::Side::coupler, message, peer.expected.name);
  peer.asked = wire::name(message.kind);
  peer.window = message.window;
  peer.busy = true;
  if (peer.inside) {
    peer.inside->take(message);
    return;
  }
  try {
    listener_.send(peer.identity, message);
  } catch (const ProtocolError& error) {
    throw_broken(peer, error);
  }
}

wire::Message& Peers::wait(std::size_t index) {
  auto& peer = peers_[index];
  if (!peer.inside) work_inside();  // which is no waiting
  const auto begin = Clock::now();
  const auto patience = seconds(starts(peer) ? run_.start_wait_s() : run_.timeout_s);
  if (peer.inside) work_inside();
  while (!peer.has_message) {
    // A peer that has said that it works is waited for anew.
    if (!receive_one(std::max(begin, peer.last_heard) + patience, peer.identity)) throw_silent(peer);
  }
  peer.doing.clear();
  peer.has_message = false;
  note_wait(index, begin);
  return *peer.inbox;
}

/// Before the coupler waits: all that a participant in this process can do by now.
void Peers::work_inside() {
  for (auto& peer : peers_) {
    if (!peer.inside) continue;
    launcher_.poll();
    attend();
    if (!peer.inside->work(*scratch_)) continue;
    take_answer(peer);
  }
}

bool Peers::starts(const Remote& peer) {
  return peer.asked == wire::name(wire::Kind::describe) || peer.asked == wire::name(wire::Kind::initialize);
}

void Peers::note_wait(std::size_t index, Clock::time_point begin) {
  auto& peer = peers_[index];
  const auto end = Clock::now();
  const double waited = std::chrono::duration<double>(end - begin).count();
  peer.waited_s += waited;
  for (auto& other : peers_) {
    if (!other.busy) other.idle_while_s[index] += waited;
  }
  peer.busy = false;
  if (peer.spans.size() < max_spans) peer.spans.push_back({peer.window, since_epoch_s(begin), since_epoch_s(end)});
}

/// One message or one event of the processes; false at the deadline. `awaited`: whose message is wanted, if anybody's.
bool Peers::receive_one(wire::Deadline deadline, const std::string& awaited) {
  launcher_.poll();
  if (Clock::now() >= next_look_at_logs_) check_logs();
  if (attend()) return true;  // which may have brought what the caller waits for
  if (receive_into_scratch(std::min(deadline, next_look_at_logs_), awaited, true)) {
    deliver();
    return true;
  }
  return Clock::now() < deadline || launcher_.events() != seen_events_ || listener_.closings() != seen_closings_;
}

/// All that a program prints goes to the disk of the user, and some never stop.
void Peers::check_logs() {
  next_look_at_logs_ = Clock::now() + between_looks_at_logs;
  for (const auto& peer : peers_) {
    const auto path = launcher_.log_path(peer.expected.name);
    std::error_code error;
    const auto size = path.empty() ? 0 : std::filesystem::file_size(path, error);
    if (error || size <= largest_log) continue;
    throw ParticipantError(fmt::format("participant '{}' has printed {} bytes to its log {}, allowed are {}",
                                       peer.expected.name, size, path, largest_log));
  }
}

bool Peers::receive_into_scratch(wire::Deadline deadline, const std::string& awaited, bool watch_processes) {
  const auto ready = [this](std::size_t) {
    launcher_.poll();
    return launcher_.events() == seen_events_;
  };
  static const std::vector<int> nothing;
  for (;;) {
    scratch_identity_ = awaited;
    try {
      return listener_.receive(scratch_identity_, *scratch_, deadline, watch_processes ? descriptors_ : nothing, ready);
    } catch (const ProtocolError& error) {
      const auto* peer = find(scratch_identity_);
      if (peer) throw_broken(*peer, error);
      if (scratch_identity_.empty()) throw;
      refuse(error.what(), static_cast<int>(ExitCode::protocol));  // a stranger's nonsense is not the run's trouble
    }
  }
}

void Peers::deliver() {
  auto* peer = find(scratch_identity_);
  if (!peer) {
    admit();
    return;
  }
  take_answer(*peer);
}

/// The message in `scratch_` is this peer's.
void Peers::take_answer(Remote& peer) {
  peer.lifecycle.step(wire::Side::participant, *scratch_, peer.expected.name);
  if (scratch_->kind != wire::Kind::failure && scratch_->run_id != run_.run_id) {
    throw ProtocolError(fmt::format("participant '{}' sent a message of run '{}', this is run '{}'", peer.expected.name,
                                    scratch_->run_id, run_.run_id));
  }
  peer.last_heard = Clock::now();
  if (scratch_->kind == wire::Kind::progress) return take_progress(peer);
  std::swap(peer.inbox, scratch_);
  if (peer.inbox->kind == wire::Kind::failure) throw_failure(peer);
  peer.has_message = true;
}

void Peers::take_progress(Remote& peer) {
  const auto& progress = scratch_->as<wire::Progress>();
  peer.doing = fmt::format("{}{}", progress.doing,
                           progress.share_done < 0.0 ? "" : fmt::format(", {:.0f} %", 100.0 * progress.share_done));
  if (on_progress_) on_progress_(peer.expected.name, progress.doing, progress.share_done);
}

Peers::Remote* Peers::find(const std::string& identity) {
  if (identity.empty()) return nullptr;
  for (auto& peer : peers_) {
    if (peer.identity == identity) return &peer;
  }
  return nullptr;
}

/// Processes that ended, connections that were closed and signals that came since the last call; false if there were
/// none.
bool Peers::attend() {
  if (listener_.closings() != seen_closings_) {
    check_connections();
    return true;
  }
  if (launcher_.events() == seen_events_) return false;
  seen_events_ = launcher_.events();
  if (launcher_.interrupted_by() != 0) throw Interrupted(launcher_.interrupted_by());
  for (auto& peer : peers_) check_end(peer);
  return true;
}

void Peers::check_end(Remote& peer) {
  const auto end = launcher_.end_of(peer.expected.name);
  if (!end || peer.end_handled) return;
  peer.end_handled = true;
  hear_last_words(peer);
  if (peer.lifecycle.done()) return;
  throw ParticipantError(
      fmt::format("{} {} {}{}{}", who(peer), end->text(), place(peer), refusal_text(peer), log_tail(peer)));
}

/// Until they have been heard or nothing can come any more, whoever else talks or goes meanwhile.
void Peers::hear_last_words(Remote& peer) {
  const auto deadline = Clock::now() + seconds(drain_s);
  while (!peer.lifecycle.done() && Clock::now() < deadline) {
    if (receive_into_scratch(deadline, peer.identity, false)) deliver();
  }
}

/// More can be told of a process that was launched here when it has ended; of others the connection is all there is.
/// Whoever launched one on another machine may know why it ended, but not if that machine is gone. A message beyond
/// the limit is not received: ZeroMQ closes its connection.
void Peers::check_connections() {
  seen_closings_ = listener_.closings();
  for (auto& peer : peers_) {
    const bool launched = launcher_.launched(peer.expected.name);
    if (peer.identity.empty() || peer.lifecycle.done() || !listener_.gone(peer.identity)) continue;
    if (launched && launcher_.wait_for(peer.expected.name, until_told_why)) check_end(peer);
    hear_last_words(peer);
    if (peer.lifecycle.done()) continue;
    if (launched && !peer.expected.through_another)
      throw ProtocolError(fmt::format(
          "{} has no connection any more {}, though its process runs: it closed it, or sent a message of more than {} "
          "bytes, which are allowed{}",
          who(peer), place(peer), run_.largest_message, log_tail(peer)));
    throw ParticipantError(fmt::format(
        "{} is gone {}: its connection was closed, the process ({}, {} on its machine) ended or was killed, or sent a "
        "message of more than {} bytes, which are allowed{}",
        who(peer), place(peer), launched ? "what launched it still runs" : "started by hand", peer.process_id,
        run_.largest_message, log_tail(peer)));
  }
}

void Peers::limit(std::size_t index, const wire::Description& description) {
  constexpr std::size_t least = std::size_t{1} << 18;  // texts, and the times of `finished`
  constexpr std::size_t most_rows = 4200;  // of each kind in one answer: as many windows as a baseline takes at once
  const auto numbers = 8 * description.interface_position_m.data.size() +
                       most_rows * (2 * description.record_columns.size() + description.axial_stress_columns.size() +
                                    description.probe_columns.size());
  const bool tells_state = description.has(Capability::load_state) || description.has(Capability::save_state);
  const std::size_t bytes = least + sizeof(double) * numbers;
  if (peers_[index].inside) return;
  listener_.limit(peers_[index].identity, tells_state ? std::max(bytes, run_.largest_message) : bytes);
}

}  // namespace ricochet::coupler
