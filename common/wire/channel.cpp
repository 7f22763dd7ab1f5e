#include "common/wire/channel.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <zmq.hpp>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"

namespace ricochet::wire {
namespace {

using Milliseconds = std::chrono::milliseconds;

double seconds_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double>(end - begin).count();
}

zmq::socket_t make_socket(zmq::context_t& context, zmq::socket_type type) {
  zmq::socket_t socket(context, type);
  socket.set(zmq::sockopt::linger, static_cast<int>(linger.count()));
  socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(max_message_bytes));
  return socket;
}

[[noreturn]] void refuse_endpoint(const std::string& endpoint, const char* what, const zmq::error_t& error) {
  throw ConfigError(fmt::format("cannot {} '{}': {}; expected ipc://@name, ipc://path or tcp://address:port", what,
                                endpoint, error.what()));
}

/// zmq::poll until the deadline; false if it has passed. Signals do not end the wait.
bool poll(std::vector<zmq::pollitem_t>& items, Deadline deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<Milliseconds>(deadline - Clock::now());
    try {
      const int ready = zmq::poll(items, std::max(left, Milliseconds(0)));
      if (ready > 0) return true;
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
      continue;
    }
    if (Clock::now() >= deadline) return false;
  }
}

/// The next frame, if it is there already.
bool receive_frame(zmq::socket_t& socket, zmq::message_t& frame) {
  for (;;) {
    try {
      return socket.recv(frame, zmq::recv_flags::dontwait).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
    }
  }
}

/// Reads the rest of a message of several frames; how many it had.
int count_frames(zmq::socket_t& socket, zmq::message_t& last) {
  int frames = 1;
  while (last.more() && receive_frame(socket, last)) ++frames;
  return frames;
}

/// Decodes a message whose only frame is `payload`.
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

}  // namespace

Deadline deadline_in(double timeout_s) {
  constexpr double year_s = 365.0 * 24 * 3600;
  const double bounded = std::isnan(timeout_s) ? 0.0 : std::clamp(timeout_s, 0.0, year_s);
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(bounded));
}

// ---- participant's end

struct Channel::Impl {
  static constexpr const char* monitor_endpoint = "inproc://connection";

  Impl() : socket(make_socket(context, zmq::socket_type::dealer)), monitor(context, zmq::socket_type::pair) {
    // A connection that breaks does not come back: messages may be lost, and the coupler would know us no more.
    zmq_socket_monitor(socket.handle(), monitor_endpoint, ZMQ_EVENT_DISCONNECTED);
    monitor.set(zmq::sockopt::linger, 0);
    monitor.connect(monitor_endpoint);
    items = {{socket.handle(), 0, ZMQ_POLLIN, 0},
             {monitor.handle(), 0, ZMQ_POLLIN, 0},
             {nullptr, STDIN_FILENO, ZMQ_POLLERR, 0}};
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { zmq_socket_monitor(socket.handle(), nullptr, 0); }  // before `monitor`: its events would have nowhere to go

  /// What broke the connection, by the last poll; null if nothing did.
  [[nodiscard]] const char* broken() const {
    if (items[1].revents != 0) return "it closed the connection";
    return items.size() > 2 && items[2].revents != 0 ? "standard input was closed" : nullptr;
  }

  zmq::context_t context;
  zmq::socket_t socket, monitor;
  std::vector<zmq::pollitem_t> items;
  zmq::message_t frame;
  msgpack::sbuffer buffer;
};

Channel::Channel(const std::string& endpoint) : impl_(std::make_unique<Impl>()) {
  try {
    impl_->socket.connect(endpoint);
  } catch (const zmq::error_t& error) {
    refuse_endpoint(endpoint, "connect to", error);
  }
}

Channel::~Channel() = default;

void Channel::send(const Message& message) {
  encode(message, impl_->buffer);
  send_frame(impl_->socket, impl_->buffer.data(), impl_->buffer.size(), zmq::send_flags::none);
}

void Channel::receive(Message& message, Deadline deadline, bool watch_stdin) {
  const auto begin = Clock::now();
  auto& items = impl_->items;
  items.resize(watch_stdin ? 3 : 2);
  if (watch_stdin) items[2] = {nullptr, STDIN_FILENO, ZMQ_POLLERR, 0};
  while (!receive_frame(impl_->socket, impl_->frame)) {
    if (!poll(items, deadline)) {
      throw ParticipantError(
          fmt::format("the coupler has not answered within {:.3g} s: it hangs, is stopped, or its address "
                      "is wrong",
                      seconds_between(begin, deadline)));
    }
    const char* broken = impl_->broken();
    if (!broken) continue;
    if (receive_frame(impl_->socket, impl_->frame)) break;  // its last words
    impl_->socket.set(zmq::sockopt::linger, 0);  // what it has not read must not reach the next run at this address
    throw ParticipantError(fmt::format("the coupler is gone: {}", broken));
  }
  decode_frame(impl_->socket, impl_->frame, "the coupler", message);
}

// ---- coupler's end

struct Listener::Impl {
  zmq::context_t context;
  zmq::socket_t socket = make_socket(context, zmq::socket_type::router);
  std::vector<zmq::pollitem_t> items;
  zmq::message_t identity, frame;
  msgpack::sbuffer buffer;
};

Listener::Listener(const std::string& endpoint) : impl_(std::make_unique<Impl>()) {
  try {
    impl_->socket.bind(endpoint);
  } catch (const zmq::error_t& error) {
    refuse_endpoint(endpoint, "listen at", error);
  }
}

Listener::~Listener() = default;

std::string Listener::endpoint() const { return impl_->socket.get(zmq::sockopt::last_endpoint); }

bool Listener::receive(std::string& identity, Message& message, Deadline deadline,
                       const std::vector<int>& file_descriptors, const std::function<bool(std::size_t)>& ready) {
  auto& items = impl_->items;
  items.assign(1, {impl_->socket.handle(), 0, ZMQ_POLLIN, 0});
  for (const int descriptor : file_descriptors) items.push_back({nullptr, descriptor, ZMQ_POLLIN | ZMQ_POLLERR, 0});
  while (!receive_frame(impl_->socket, impl_->identity)) {
    if (!poll(items, deadline)) return false;
    for (std::size_t i = 1; i < items.size(); ++i) {
      if (items[i].revents != 0 && !ready(i - 1)) return false;
    }
  }
  identity.assign(impl_->identity.data<char>(), impl_->identity.size());
  // The frames of a message come together; one of an identity alone is not one of ours.
  if (!impl_->identity.more() || !receive_frame(impl_->socket, impl_->frame))
    throw ProtocolError("the peer sent no message");
  decode_frame(impl_->socket, impl_->frame, "the peer", message);
  return true;
}

void Listener::send(const std::string& identity, const Message& message) {
  encode(message, impl_->buffer);
  send_frame(impl_->socket, identity.data(), identity.size(), zmq::send_flags::sndmore);
  send_frame(impl_->socket, impl_->buffer.data(), impl_->buffer.size(), zmq::send_flags::none);
}

}  // namespace ricochet::wire
