#include "common/wire/channel.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/shared_memory.hpp"
#include "common/wire/sockets.hpp"

namespace ricochet::wire {
namespace {

double seconds_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double>(end - begin).count();
}

constexpr const char* coupler = "the coupler";  // for error texts

[[noreturn]] void throw_silent(Clock::time_point begin, Deadline deadline) {
  throw ParticipantError(
      fmt::format("the coupler has not answered within {:.3g} s: it hangs, is stopped, or its address is wrong",
                  seconds_between(begin, deadline)));
}

[[noreturn]] void throw_gone(const char* why) { throw CouplerGone(fmt::format("the coupler is gone: {}", why)); }

}  // namespace

Deadline deadline_in(double timeout_s) {
  constexpr double year_s = 365.0 * 24 * 3600;
  const double bounded = std::isnan(timeout_s) ? 0.0 : std::clamp(timeout_s, 0.0, year_s);
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(bounded));
}

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
  ~Impl() {
    if (shared) shared->flush_all();
    zmq_socket_monitor(socket.handle(), nullptr, 0);  // before `monitor`: its events would have nowhere to go
  }

  void receive_frame_of(Message& message, Clock::time_point begin, Deadline deadline);
  void receive_shared(Message& message, Clock::time_point begin, Deadline deadline);
  void take_answer_to_offer(const Welcome& welcome);

  /// The error that broke the connection, by the last poll; null if nothing did.
  [[nodiscard]] const char* broken() const {
    if (items[1].revents != 0) {
      return heard ? "it closed the connection"
                   : "it closed the connection before it answered: it does not know this key, or has all its "
                     "participants";
    }
    return items.size() > 2 && items[2].revents != 0 ? "standard input was closed" : nullptr;
  }

  zmq::context_t context;
  zmq::socket_t socket, monitor;
  std::vector<zmq::pollitem_t> items;
  zmq::message_t frame;
  Pieces pieces;
  msgpack::sbuffer buffer;
  std::unique_ptr<SharedMemory> offered, shared;
  bool heard = false;  ///< anything so far
};

Channel::Channel(const std::string& endpoint, const std::optional<ParticipantKey>& key)
    : impl_(std::make_unique<Impl>()) {
  try {
    if (key) {
      impl_->socket.set(zmq::sockopt::curve_serverkey, key->coupler_public_key);
      impl_->socket.set(zmq::sockopt::curve_publickey, key->own.public_key);
      impl_->socket.set(zmq::sockopt::curve_secretkey, key->own.secret_key);
    }
    impl_->socket.connect(endpoint);
  } catch (const zmq::error_t& error) {
    refuse_endpoint(endpoint, "connect to", error);
  }
}

Channel::~Channel() = default;

void Channel::offer_shared_memory(Hello& hello) {
  impl_->offered = SharedMemory::make();
  if (!impl_->offered) return;
  hello.shared_memory_path = impl_->offered->path();
  hello.shared_memory_key = impl_->offered->key();
}

void Channel::send(const Message& message) {
  if (impl_->shared) {
    encode(message, impl_->pieces);
    impl_->shared->sender().send(impl_->pieces.in_order());
  } else {
    encode(message, impl_->buffer);
    send_frame(impl_->socket, impl_->buffer.data(), impl_->buffer.size(), zmq::send_flags::none);
  }
}

void Channel::receive(Message& message, Deadline deadline, bool watch_stdin) {
  auto& items = impl_->items;
  items.resize(watch_stdin ? 3 : 2);
  if (watch_stdin) items[2] = {nullptr, STDIN_FILENO, ZMQ_POLLERR, 0};
  if (impl_->shared) {
    impl_->receive_shared(message, Clock::now(), deadline);
  } else {
    impl_->receive_frame_of(message, Clock::now(), deadline);
    if (message.kind == Kind::welcome) impl_->take_answer_to_offer(message.as<Welcome>());
  }
}

void Channel::Impl::receive_frame_of(Message& message, Clock::time_point begin, Deadline deadline) {
  while (!receive_frame(socket, frame)) {
    if (!poll(items, deadline)) throw_silent(begin, deadline);
    const char* why = broken();
    if (!why) continue;
    if (receive_frame(socket, frame)) break;  // its last words
    socket.set(zmq::sockopt::linger, 0);      // what it has not read must not reach the next run at this address
    throw_gone(why);
  }
  heard = true;
  decode_frame(socket, frame, coupler, message);
}

void Channel::Impl::receive_shared(Message& message, Clock::time_point begin, Deadline deadline) {
  auto next_look = begin + look_every;
  while (!shared->receiver().receive(coupler)) {
    const auto now = Clock::now();
    if (now >= deadline) throw_silent(begin, deadline);
    if (now >= next_look) {
      next_look = now + look_every;
      const char* why = poll(items, now) ? broken() : nullptr;
      if (why && shared->receiver().receive(coupler)) break;  // its last words
      if (why) throw_gone(why);
    }
    shared->wait(std::min(deadline, next_look));
  }
  decode(shared->receiver().message(), coupler, message);
}

void Channel::Impl::take_answer_to_offer(const Welcome& welcome) {
  if (welcome.shared_memory && !offered) {
    throw ProtocolError("the coupler sent 'welcome' with shared memory, which 'hello' has not offered");
  }
  if (welcome.shared_memory) shared = std::move(offered);
  offered.reset();
}

}  // namespace ricochet::wire
