#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/wire/keys.hpp"
#include "common/wire/message.hpp"

/// Messages between processes. The coupler has one `Listener`, each participant a `Channel`. They meet over ZeroMQ
/// (ROUTER and DEALER, a message is one frame); after `welcome` a link may go through memory that both ends share, the
/// same bytes. Whoever closes its end waits at most `linger` for what it said last to get out.
namespace ricochet::wire {

class SharedMemory;

using Clock = std::chrono::steady_clock;
using Deadline = Clock::time_point;

inline constexpr std::chrono::milliseconds linger{500};
/// Largest message of somebody who is not known yet [bytes]: a `hello`.
inline constexpr std::size_t first_message_limit = std::size_t{1} << 16;
/// Largest message to a listener that nobody tells how large they may be [bytes].
inline constexpr std::size_t default_largest_message = std::size_t{1} << 26;
/// How often who exchanges messages through shared memory looks at everything else: sockets, ended processes, signals.
inline constexpr std::chrono::milliseconds look_every{5};

/// The instant `timeout_s` from now; a negative timeout counts as none, one beyond a year as a year.
[[nodiscard]] Deadline deadline_in(double timeout_s);

/// There is nobody to tell.
struct CouplerGone : ParticipantError {
  using ParticipantError::ParticipantError;
};

/// Participant's end.
class Channel {
 public:
  /// Throws ConfigError if `endpoint` is none. Connecting goes on in the background: the coupler may come later.
  /// `key`: by which the two ends know each other; without one only a listener without keys answers.
  explicit Channel(const std::string& endpoint, const std::optional<ParticipantKey>& key = std::nullopt);
  ~Channel();
  /// Adds to `hello` the offer of shared memory, if this system has any; the coupler's `welcome` says whether it is
  /// used.
  void offer_shared_memory(Hello& hello);
  /// `message`: of finite numbers only (`require_finite`).
  void send(const Message& message);
  /// Waits for one message. Throws ParticipantError "the coupler has not answered within ... s" at the deadline, and
  /// CouplerGone as soon as the connection breaks, or stdin closes if `watch_stdin`. ProtocolError from decoding.
  void receive(Message& message, Deadline deadline, bool watch_stdin);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Coupler's end: many participants on one socket, those that share memory with it besides.
class Listener {
 public:
  /// `endpoint` "ipc://*" (a socket in a folder of its own that only this user may enter), "ipc://@name" (abstract
  /// socket: anybody on this machine), "ipc://path" or "tcp://address:port" ("tcp://address:*"). Throws ConfigError if
  /// it is none, or taken. `participants`: for each a key pair is made, and nobody else gets a byte through; without
  /// names anybody may talk. A connection that sends a message above `largest_message` bytes is closed.
  explicit Listener(const std::string& endpoint, const std::vector<std::string>& participants = {},
                    std::size_t largest_message = default_largest_message);
  ~Listener();
  /// The key that `name` needs to be let in.
  [[nodiscard]] const ParticipantKey& key_of(const std::string& name) const;
  /// Whose key the sender of the last message has; empty without keys.
  [[nodiscard]] const std::string& sender() const;
  /// Everybody is there: from now on connections are closed as they come, and the folder of the socket is gone.
  void close_door();
  /// How many connections of those who had said something are closed by now; `receive` returns when one more is.
  [[nodiscard]] std::uint64_t closings() const;
  /// Whether the connection of who sent messages as `identity` is closed. It may have left last words.
  [[nodiscard]] bool gone(const std::string& identity) const;
  /// Largest message that is taken from `identity` from now on [bytes]; before that `first_message_limit`.
  void limit(const std::string& identity, std::size_t bytes);
  [[nodiscard]] std::string endpoint() const;  ///< with the port that was picked
  /// From now on messages to and from `identity` go through `memory`.
  void share(const std::string& identity, std::unique_ptr<SharedMemory> memory);
  /// `identity`: on entry, of whom an answer is awaited, whose message is then taken with the least delay (empty: of
  /// nobody in particular); afterwards that of the sender. Fills in the message; false at the deadline or when one of
  /// `file_descriptors` became readable (then `ready` is called with its index, and waiting goes on while it returns
  /// true), or a connection was closed (`closings`). They are looked at once every `look_every` at least, however fast
  /// messages come. ProtocolError from decoding: `identity` then is the sender's.
  bool receive(std::string& identity, Message& message, Deadline deadline, const std::vector<int>& file_descriptors,
               const std::function<bool(std::size_t)>& ready);
  /// To a peer that is gone it does nothing: its silence is noticed by who waits for its answer. Throws SolverError if
  /// a number of the message is not finite.
  void send(const std::string& identity, const Message& message);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ricochet::wire
