#include "common/wire/door.hpp"

#include <linux/filter.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "common/wire/channel.hpp"

namespace ricochet::wire {
namespace {

constexpr const char* key_requests = "inproc://zeromq.zap.01";  // where ZeroMQ asks
constexpr const char* connection_events = "inproc://door";
constexpr std::chrono::milliseconds longest_handshake{5000};
/// Connections that have said nothing yet; the oldest one beyond is closed. There are so many that a participant
/// has said hello on a busy machine before others have come in such numbers.
constexpr std::size_t most_silent = 128;
/// Connections that are taken in `pause`, to be closed at once, when the door is closed; after them none are.
constexpr int most_newcomers = 16;
constexpr std::chrono::milliseconds pause{1000};

/// Shuts a connection of a listening socket. Its number may be that of something else by now, such as the pipe to a
/// child: that has no address.
void shut(int connection) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (getsockname(connection, reinterpret_cast<sockaddr*>(&address), &size) != 0) return;
  const bool nameless = address.ss_family == AF_UNIX && size <= sizeof(sa_family_t);
  if (!nameless) shutdown(connection, SHUT_RDWR);
}

}  // namespace

Door::Door(zmq::context_t& context, zmq::socket_t& socket, const std::vector<std::string>& participants)
    : requests_(context, zmq::socket_type::rep), events_(context, zmq::socket_type::pair) {
  socket.set(zmq::sockopt::handshake_ivl, static_cast<int>(longest_handshake.count()));
  zmq_socket_monitor(socket.handle(), connection_events,
                     ZMQ_EVENT_LISTENING | ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED);
  events_.set(zmq::sockopt::linger, 0);
  events_.connect(connection_events);
  requests_.set(zmq::sockopt::linger, 0);
  if (participants.empty()) return;
  requests_.bind(key_requests);
  const auto own = make_key_pair();
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_secretkey, own.secret_key);
  socket.set(zmq::sockopt::zap_domain, std::string("ricochet"));
  for (const auto& name : participants) {
    const auto& key = keys_[name] = {own.public_key, make_key_pair()};
    std::array<std::uint8_t, 32> bytes{};
    zmq_z85_decode(bytes.data(), key.own.public_key.c_str());
    names_[std::string(bytes.begin(), bytes.end())] = name;
  }
}

void Door::add_items(std::vector<zmq::pollitem_t>& items) {
  items.push_back({requests_.handle(), 0, ZMQ_POLLIN, 0});
  items.push_back({events_.handle(), 0, ZMQ_POLLIN, 0});
}

std::uint64_t Door::note_message(int descriptor) {
  attend();  // the connection may be new
  silent_.erase(descriptor);
  return connection(descriptor);
}

/// A short queue before the door leaves less to take and close when a pause begins.
void Door::close() {
  closed_ = true;
  constexpr int few = 4;
  if (listening_ >= 0) listen(listening_, few);
}

std::uint64_t Door::connection(int descriptor) const {
  const auto found = open_.find(descriptor);
  return found == open_.end() ? 0 : found->second;
}

void Door::attend() {
  answer_key_request();
  note_event();
  close_silent_ones();
}

/// A request: version, number, domain, address, identity, mechanism, credentials. The answer: version, number, status,
/// its text, whose key it is, nothing.
void Door::answer_key_request() {
  for (zmq::message_t frame; has_keys() && receive_frame(requests_, frame);) {
    std::vector<std::string> words{frame.to_string()};
    while (frame.more() && receive_frame(requests_, frame)) words.push_back(frame.to_string());
    const auto found = words.size() == 7 && words[5] == "CURVE" ? names_.find(words[6]) : names_.end();
    const bool known = found != names_.end() && !closed_;
    if (known) ++let_in_[found->second];
    const std::array<std::string, 6> answer = {"1.0",
                                               words.size() > 1 ? words[1] : "",
                                               known ? "200" : "400",
                                               known ? "OK" : "no key of this run",
                                               known ? found->second : "",
                                               ""};
    for (std::size_t i = 0; i < answer.size(); ++i) {
      const auto more = i + 1 < answer.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
      send_frame(requests_, answer[i].data(), answer[i].size(), more);
    }
  }
}

/// An event: 16 bits that say what happened, 32 bits that say to which connection; then the address.
void Door::note_event() {
  for (zmq::message_t frame; receive_frame(events_, frame);) {
    std::uint16_t event = 0;
    std::int32_t connection = 0;
    std::memcpy(&event, frame.data(), sizeof event);
    std::memcpy(&connection, frame.data<char>() + sizeof event, sizeof connection);
    while (frame.more() && receive_frame(events_, frame)) {
    }
    if (event == ZMQ_EVENT_LISTENING) {
      listening_ = connection;
    } else if (event == ZMQ_EVENT_ACCEPTED) {
      note_accepted(connection);
    } else {
      const bool was_silent = silent_.erase(connection) > 0;
      if (open_.erase(connection) > 0 && !was_silent) ++closings_;
    }
  }
}

void Door::note_accepted(int connection) {
  silent_[connection] = open_[connection] = ++accepted_;
  if (!closed_ || pause_until_) return;
  const auto now = Clock::now();
  if (now - counted_from_ > pause) {
    counted_from_ = now;
    newcomers_ = 0;
  }
  if (++newcomers_ > most_newcomers) begin_pause();
}

/// A filter that lets no packet through: who connects is not answered, tries again by itself after a second, and is
/// told then that the door is closed. Connections that exist have sockets of their own and are as before. Where the
/// socket takes no filter, it goes on taking connections.
void Door::begin_pause() {
  sock_filter drop = BPF_STMT(BPF_RET | BPF_K, 0);
  const sock_fprog filter{1, &drop};
  if (setsockopt(listening_, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0) {
    pause_until_ = Clock::now() + pause;
  }
}

void Door::end_pause() {
  if (!pause_until_ || Clock::now() < *pause_until_) return;
  const int ignored = 0;
  setsockopt(listening_, SOL_SOCKET, SO_DETACH_FILTER, &ignored, sizeof ignored);
  pause_until_.reset();
  newcomers_ = 0;
}

void Door::close_silent_ones() {
  while (!silent_.empty() && (closed_ || silent_.size() > most_silent)) {
    const auto oldest = std::min_element(silent_.begin(), silent_.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
    shut(oldest->first);
    silent_.erase(oldest);
  }
}

}  // namespace ricochet::wire
