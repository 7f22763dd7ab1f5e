#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/wire/keys.hpp"
#include "common/wire/sockets.hpp"

namespace ricochet::wire {

/// Who gets in at a listening socket: asks everybody for a key of this run (ZAP, the authentication protocol of
/// ZeroMQ), and watches the connections. Works when `attend` is called.
class Door {
 public:
  /// Before the socket is bound. Without names everybody is let in.
  Door(zmq::context_t& context, zmq::socket_t& socket, const std::vector<std::string>& participants);

  /// Appends the two sockets that tell when there is something to attend to.
  void add_items(std::vector<zmq::pollitem_t>& items);
  void attend();
  /// From now on every new connection is closed at once.
  void close() { closed_ = true; }
  /// A message has come over the connection with this file descriptor. Its number, counted from 1 as they come, because
  /// another one may get the descriptor later; 0: it is closed already.
  std::uint64_t note_message(int descriptor);
  /// Number of the connection that has this file descriptor now; 0: none.
  [[nodiscard]] std::uint64_t connection(int descriptor) const;
  /// How many connections that had said something have been closed so far.
  [[nodiscard]] std::uint64_t closings() const { return closings_; }
  [[nodiscard]] bool has_keys() const { return !names_.empty(); }
  [[nodiscard]] const ParticipantKey& key_of(const std::string& name) const { return keys_.at(name); }

 private:
  void answer_key_request();
  void note_event();
  void close_silent_ones();

  zmq::socket_t requests_, events_;
  std::map<std::string, ParticipantKey> keys_;  ///< by name
  std::map<std::string, std::string> names_;    ///< by public key, 32 bytes
  std::map<int, std::uint64_t> open_;           ///< number of the connection by file descriptor
  std::map<int, std::uint64_t> silent_;         ///< of those that have said nothing
  std::uint64_t accepted_ = 0, closings_ = 0;
  bool closed_ = false;
};

}  // namespace ricochet::wire
