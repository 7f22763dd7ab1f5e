// The coupler's end of the channels.
#include <algorithm>

#include "common/base/error.hpp"
#include "common/wire/channel.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/shared_memory.hpp"
#include "common/wire/sockets.hpp"

namespace ricochet::wire {

struct Listener::Impl {
  struct Link {
    std::string identity;
    std::unique_ptr<SharedMemory> memory;
  };

  /// Null for who shares no memory.
  [[nodiscard]] const Link* link_to(const std::string& whose) const {
    const auto is_to = [&](const Link& link) { return link.identity == whose; };
    const auto found = std::find_if(links.begin(), links.end(), is_to);
    return found == links.end() ? nullptr : &*found;
  }
  bool receive_shared(const Link* awaited, std::string& sender, Message& message);
  bool receive_socket(std::string& sender, Message& message);
  /// Whether the socket, or a file that `ready` has nothing against, has something to read until then.
  enum class Look { nothing, something, stop };
  Look look(Deadline until, const std::function<bool(std::size_t)>& ready);

  zmq::context_t context;
  zmq::socket_t socket = make_socket(context, zmq::socket_type::router);
  std::vector<zmq::pollitem_t> items;
  zmq::message_t identity, frame;
  msgpack::sbuffer buffer;
  std::vector<Link> links;
  Clock::time_point next_look;
};

Listener::Listener(const std::string& endpoint) : impl_(std::make_unique<Impl>()) {
  try {
    impl_->socket.bind(endpoint);
  } catch (const zmq::error_t& error) {
    refuse_endpoint(endpoint, "listen at", error);
  }
}

Listener::~Listener() {
  for (auto& link : impl_->links) link.memory->flush_all();
}

std::string Listener::endpoint() const { return impl_->socket.get(zmq::sockopt::last_endpoint); }

void Listener::share(const std::string& identity, std::unique_ptr<SharedMemory> memory) {
  impl_->links.push_back({identity, std::move(memory)});
}

bool Listener::receive(std::string& identity, Message& message, Deadline deadline,
                       const std::vector<int>& file_descriptors, const std::function<bool(std::size_t)>& ready) {
  auto& items = impl_->items;
  items.assign(1, {impl_->socket.handle(), 0, ZMQ_POLLIN, 0});
  for (const int descriptor : file_descriptors) items.push_back({nullptr, descriptor, ZMQ_POLLIN | ZMQ_POLLERR, 0});
  const auto* awaited = impl_->link_to(identity);
  for (;;) {
    const auto now = Clock::now();
    if (!awaited && impl_->receive_socket(identity, message)) return true;
    if (!awaited || now >= impl_->next_look) {
      const auto until = awaited ? now : impl_->links.empty() ? deadline : std::min(deadline, now + look_every);
      impl_->next_look = now + look_every;
      const auto seen = impl_->look(until, ready);
      if (seen == Impl::Look::stop) return false;
      if (seen == Impl::Look::something && impl_->receive_socket(identity, message)) return true;
    }
    if (impl_->receive_shared(awaited, identity, message)) return true;
    if (Clock::now() >= deadline) return false;
    if (awaited) awaited->memory->wait(std::min(deadline, impl_->next_look));
  }
}

/// A message that has come through shared memory; `sender` is set before an error can be that of a peer.
bool Listener::Impl::receive_shared(const Link* awaited, std::string& sender, Message& message) {
  const auto take = [&](const Link& link) {
    sender = link.identity;
    link.memory->sender().flush();
    if (!link.memory->receiver().receive("the peer")) return false;
    decode(link.memory->receiver().message(), "the peer", message);
    return true;
  };
  if (awaited && take(*awaited)) return true;
  for (const auto& link : links) {
    if (&link != awaited && take(link)) return true;
  }
  if (awaited) sender = awaited->identity;
  return false;
}

bool Listener::Impl::receive_socket(std::string& sender, Message& message) {
  if (!receive_frame(socket, identity)) return false;
  sender.assign(identity.data<char>(), identity.size());
  // The frames of a message come together; one of an identity alone is not one of ours.
  if (!identity.more() || !receive_frame(socket, frame)) throw ProtocolError("the peer sent no message");
  decode_frame(socket, frame, "the peer", message);
  return true;
}

Listener::Impl::Look Listener::Impl::look(Deadline until, const std::function<bool(std::size_t)>& ready) {
  if (!poll(items, until)) return Look::nothing;
  for (std::size_t i = 1; i < items.size(); ++i) {
    if (items[i].revents != 0 && !ready(i - 1)) return Look::stop;
  }
  return Look::something;
}

void Listener::send(const std::string& identity, const Message& message) {
  encode(message, impl_->buffer);
  if (const auto* link = impl_->link_to(identity)) {
    link->memory->sender().send({impl_->buffer.data(), impl_->buffer.size()});
    return;
  }
  send_frame(impl_->socket, identity.data(), identity.size(), zmq::send_flags::sndmore);
  send_frame(impl_->socket, impl_->buffer.data(), impl_->buffer.size(), zmq::send_flags::none);
}

}  // namespace ricochet::wire
