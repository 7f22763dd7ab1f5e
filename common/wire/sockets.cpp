#include "common/wire/sockets.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"

namespace ricochet::wire {
namespace {

/// Messages of one peer that wait to be read: it sends one at a time, and who sends more waits.
constexpr int most_waiting = 8;

/// Reads the rest of a message of several frames; how many it had.
int count_frames(zmq::socket_t& socket, zmq::message_t& last) {
  int frames = 1;
  while (last.more() && receive_frame(socket, last)) ++frames;
  return frames;
}

}  // namespace

zmq::socket_t make_socket(zmq::context_t& context, zmq::socket_type type) {
  zmq::socket_t socket(context, type);
  socket.set(zmq::sockopt::linger, static_cast<int>(linger.count()));
  socket.set(zmq::sockopt::rcvhwm, most_waiting);
  socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(max_message_bytes));
  return socket;
}

void refuse_endpoint(const std::string& endpoint, const char* what, const zmq::error_t& error) {
  throw ConfigError(fmt::format("cannot {} '{}': {}; expected ipc://@name, ipc://path or tcp://address:port", what,
                                endpoint, error.what()));
}

bool poll(std::vector<zmq::pollitem_t>& items, Deadline deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    try {
      const int ready = zmq::poll(items, std::max(left, std::chrono::milliseconds(0)));
      if (ready > 0) return true;
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
      continue;
    }
    if (Clock::now() >= deadline) return false;
  }
}

bool receive_frame(zmq::socket_t& socket, zmq::message_t& frame) {
  for (;;) {
    try {
      return socket.recv(frame, zmq::recv_flags::dontwait).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
    }
  }
}

void decode_frame(zmq::socket_t& socket, zmq::message_t& payload, std::string_view sender, Message& message) {
  if (payload.more()) {
    const int frames = count_frames(socket, payload);
    throw ProtocolError(fmt::format("{} sent a message of {} frames, expected one", sender, frames));
  }
  decode({payload.data<char>(), payload.size()}, sender, message);
}

void send_frame(zmq::socket_t& socket, const void* data, std::size_t size, zmq::send_flags flags) {
  if (!socket.send(zmq::const_buffer(data, size), flags | zmq::send_flags::dontwait)) {
    throw ParticipantError("the connection takes no more messages: the other end does not read them");
  }
}

}  // namespace ricochet::wire
