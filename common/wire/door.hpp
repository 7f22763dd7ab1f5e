#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/channel.hpp"
#include "common/wire/keys.hpp"
#include "common/wire/sockets.hpp"

namespace ricochet::wire {

/// Decides who gets in at a listening socket: asks everybody for a key of this run (ZAP, the authentication protocol of
/// ZeroMQ), and watches the connections. Works when `attend` is called. Taking a connection and closing it costs some
/// tens of microseconds; once the door is closed, so many at most are taken per second that they slow no run, and the
/// kernel drops the others before anybody here hears of them.
class Door {
 public:
  /// Before the socket is bound. Without names everybody is let in.
  Door(zmq::context_t& context, zmq::socket_t& socket, const std::vector<std::string>& participants);

  /// Appends the two sockets that tell when there is something to attend to.
  void add_items(std::vector<zmq::pollitem_t>& items);
  void attend();
  /// From now on every new connection is closed at once; of many none are taken for a while.
  void close();
  /// Lets connections come again after the while in which none are taken.
  void end_pause();
  /// A message has come over the connection with this file descriptor. Its number, counted from 1 as they come, because
  /// another one may get the descriptor later; 0: it is closed already.
  std::uint64_t note_message(int descriptor);
  /// Number of the connection that has this file descriptor now; 0: none.
  [[nodiscard]] std::uint64_t connection(int descriptor) const;
  /// How many connections that had said something have been closed so far.
  [[nodiscard]] std::uint64_t closings() const { return closings_; }
  /// Whether the key of `name` has opened one connection and no other.
  [[nodiscard]] bool let_in_once(const std::string& name) const {
    const auto found = let_in_.find(name);
    return found != let_in_.end() && found->second == 1;
  }
  [[nodiscard]] bool has_keys() const { return !names_.empty(); }
  [[nodiscard]] const ParticipantKey& key_of(const std::string& name) const { return keys_.at(name); }

 private:
  void answer_key_request();
  void note_event();
  void note_accepted(int connection);
  void close_silent_ones();
  void begin_pause();

  zmq::socket_t requests_, events_;
  std::map<std::string, ParticipantKey> keys_;  ///< by name
  std::map<std::string, std::string> names_;    ///< by public key, 32 bytes
  std::map<int, std::uint64_t> open_;           ///< number of the connection by file descriptor
  std::map<int, std::uint64_t> silent_;         ///< of those that have said nothing
  std::map<std::string, int> let_in_;           ///< how often, by name
  std::uint64_t accepted_ = 0, closings_ = 0;
  bool closed_ = false;
  int listening_ = -1;  ///< file descriptor of the socket that takes connections
  int newcomers_ = 0;   ///< since `counted_from_`, after the door was closed
  Clock::time_point counted_from_;
  std::optional<Deadline> pause_until_;
};

}  // namespace ricochet::wire
