#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/window_clock.hpp"
#include "common/wire/channel.hpp"
#include "common/wire/lifecycle.hpp"
#include "common/wire/shared_memory.hpp"
#include "coupler/interface/peer.hpp"
#include "coupler/processes/inside.hpp"
#include "coupler/processes/launcher.hpp"
#include "coupler/results/trace.hpp"

namespace ricochet::coupler {

/// A participant that the scene names.
struct ExpectedPeer {
  std::string name;
  Role role = Role::explicit_solver;
  bool through_another = false;  ///< what is launched here is not its program, but one that starts it
  bool inside = false;           ///< it is no process
};

/// The last words of a process that ended are in the socket after this time [s].
inline constexpr double drain_s = 0.25;

/// The identity that all peers of a run have in common.
struct RunIdentity {
  std::string run_id;
  std::string scene_sha256;
  double timeout_s = 60.0;                             ///< longest wait for any peer
  WindowClock clock = {};                              ///< for the times in error texts
  Transport transport = Transport::automatic;          ///< as in the scene
  std::string transport_where = "coupling.transport";  ///< where the scene says so, for error texts
  std::size_t largest_message =
      wire::default_largest_message;           ///< of a participant that has not described itself [bytes]
  std::optional<double> start_timeout_s = {};  ///< the wait until it is initialized; empty: timeout_s
  [[nodiscard]] double start_wait_s() const { return start_timeout_s.value_or(timeout_s); }
};

/// The participants of a run as remote processes, one of them perhaps in this process: who is connected, whose turn it
/// is, who is late, who died.
///
/// Every wait has a deadline. A launched process that ends before it has said `finished`, a silent peer, an illegal or
/// malformed message and a failure message end the run with one error that names the participant and the window.
/// Strangers (unknown names, second participants of a name, other scenes) are told why and turned away; the run goes
/// on.
class Peers {
 public:
  Peers(wire::Listener& listener, Launcher& launcher, std::vector<ExpectedPeer> expected, RunIdentity run);

  /// A peer that is expected to be `inside` is there.
  void enter(std::size_t index, std::unique_ptr<participant::Participant> participant);
  /// Called with what a participant says of its progress before it is initialized; `share_done` < 0: it does not know.
  using OnProgress = std::function<void(const std::string& name, std::string_view doing, double share_done)>;
  void on_progress(OnProgress tell) { on_progress_ = std::move(tell); }
  /// Waits until every expected participant has said hello and welcomes it.
  void handshake();
  /// Takes no message from the participant that is larger than what it has described of itself needs.
  void limit(std::size_t index, const wire::Description& description);
  /// The participant in the form the protocols use; refers to this object.
  [[nodiscard]] Peer peer(std::size_t index);
  [[nodiscard]] std::vector<Peer> all();
  /// Tells every peer that still listens that the run is over, and why.
  void announce_failure(int code, const std::string& text, const std::string& culprit);

  [[nodiscard]] std::size_t size() const { return peers_.size(); }
  [[nodiscard]] const std::string& name(std::size_t index) const { return peers_[index].expected.name; }
  [[nodiscard]] bool inside(std::size_t index) const { return peers_[index].expected.inside; }
  [[nodiscard]] std::int64_t process_id(std::size_t index) const { return peers_[index].process_id; }
  /// The transport that carries the messages to and from this peer; empty until its hello.
  [[nodiscard]] std::optional<Transport> transport(std::size_t index) const { return peers_[index].transport; }
  /// Time that the coupler waited for this peer [s], and the spans it consists of (the first `max_spans`).
  [[nodiscard]] double waited_for_s(std::size_t index) const { return peers_[index].waited_s; }
  [[nodiscard]] const std::vector<WaitSpan>& wait_spans(std::size_t index) const { return peers_[index].spans; }
  /// Time that participant `idle` had nothing to do while the coupler waited for `busy` [s].
  [[nodiscard]] double idle_while_s(std::size_t idle, std::size_t busy) const {
    return peers_[idle].idle_while_s[busy];
  }

  static constexpr std::size_t max_spans = 100'000;

 private:
  struct Remote {
    ExpectedPeer expected;
    std::unique_ptr<Inside> inside;
    std::string identity;  ///< routing identity; empty until its hello
    wire::Lifecycle lifecycle;
    std::unique_ptr<wire::Message> inbox = std::make_unique<wire::Message>();
    std::string asked;  ///< what it was asked last, for error texts
    std::string doing;  ///< what it said last that it does
    std::optional<Transport> transport;
    std::string refusal;  ///< why a peer of this name was turned away
    std::int64_t process_id = 0;
    std::string machine;  ///< if it is not this one
    std::int64_t sequence = 0, window = 0;
    wire::Clock::time_point last_heard;
    bool has_message = false, busy = false, end_handled = false;
    double waited_s = 0.0;
    std::vector<double> idle_while_s;
    std::vector<WaitSpan> spans;
  };

  void post(Remote& peer, wire::Message& message);
  wire::Message& wait(std::size_t index);
  void work_inside();
  void take_answer(Remote& peer);
  void note_wait(std::size_t index, wire::Clock::time_point begin);
  bool receive_one(wire::Deadline deadline, const std::string& awaited);
  bool receive_into_scratch(wire::Deadline deadline, const std::string& awaited, bool watch_processes);
  void deliver();
  void admit();
  [[nodiscard]] std::string objection_to_hello(const wire::Hello& hello, const Remote& peer) const;
  std::unique_ptr<wire::SharedMemory> open_shared_memory(const wire::Hello& hello, std::string& objection) const;
  void refuse(const std::string& text, int code);
  bool attend();
  void check_end(Remote& peer);
  void check_connections();
  void check_logs();
  void hear_last_words(Remote& peer);
  Remote* find(const std::string& identity);
  [[noreturn]] void throw_broken(const Remote& peer, const ProtocolError& error) const;
  [[noreturn]] void throw_failure(const Remote& peer) const;
  [[noreturn]] void throw_silent(const Remote& peer) const;
  /// The last request to it is part of its start.
  [[nodiscard]] static bool starts(const Remote& peer);
  [[nodiscard]] static std::string who(const Remote& peer);
  [[nodiscard]] std::string place(const Remote& peer) const;
  [[nodiscard]] std::string refusal_text(const Remote& peer) const;
  [[nodiscard]] std::string log_tail(const Remote& peer) const;

  void take_progress(Remote& peer);

  OnProgress on_progress_;
  wire::Listener& listener_;
  Launcher& launcher_;
  RunIdentity run_;
  std::vector<Remote> peers_;
  std::vector<int> descriptors_;
  std::unique_ptr<wire::Message> scratch_ = std::make_unique<wire::Message>();  ///< what came last
  std::uint64_t seen_closings_ = 0;
  wire::Clock::time_point next_look_at_logs_;
  std::string scratch_identity_;
  std::string last_refusal_;  ///< what a stranger was told last
  int seen_events_ = 0;
};

}  // namespace ricochet::coupler
