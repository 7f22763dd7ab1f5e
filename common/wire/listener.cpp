// The coupler's end of the channels.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>

#include "common/base/error.hpp"
#include "common/wire/channel.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/door.hpp"
#include "common/wire/shared_memory.hpp"
#include "common/wire/sockets.hpp"

namespace ricochet::wire {

namespace {

constexpr std::ptrdiff_t door_items = 2;

/// ZeroMQ numbers its connections from where the generator of the C library happens to stand.
void seed_routing_ids() {
  static const bool once = [] {
    std::srand(std::random_device{}());
    return true;
  }();
  static_cast<void>(once);
}

constexpr std::string_view folder_prefix = "ricochet-";

/// A folder that only this user may enter, for a socket; gone with this object. It holds a lock on it, by which it is
/// known to be in use on the other side of a namespace of processes, too.
class PrivateFolder {
 public:
  PrivateFolder() {
    const char* runtime = std::getenv("XDG_RUNTIME_DIR");
    for (const std::string parent : {runtime ? runtime : "", "/tmp"}) {
      if (parent.empty()) continue;
      remove_abandoned(parent);
      path_ = fmt::format("{}/{}{}-XXXXXX", parent, folder_prefix, getpid());
      constexpr std::size_t longest = 80;  // of an address of a socket, with the name in the folder
      if (path_.size() >= longest || !mkdtemp(path_.data())) continue;
      lock_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      flock(lock_, LOCK_EX | LOCK_NB);
      return;
    }
    throw_errno(errno, "cannot create a folder in /tmp");
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  ~PrivateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
    close(lock_);
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  /// Removes folders of couplers of this user that were killed while participants came.
  static void remove_abandoned(const std::string& parent) {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(parent, ignored)) {
      const auto name = entry.path().filename().string();
      if (!name.starts_with(folder_prefix)) continue;
      const auto process = static_cast<pid_t>(std::strtol(name.c_str() + folder_prefix.size(), nullptr, 10));
      if (process <= 0 || kill(process, 0) == 0 || errno != ESRCH) continue;
      const int folder = open(entry.path().c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
      if (folder < 0) continue;
      struct stat status {};
      const bool own = fstat(folder, &status) == 0 && status.st_uid == geteuid();
      if (own && flock(folder, LOCK_EX | LOCK_NB) == 0) {
        unlinkat(folder, "socket", 0);
        rmdir(entry.path().c_str());  // only if nothing else is in it
      }
      close(folder);
    }
  }

  std::string path_;
  int lock_ = -1;
};

}  // namespace

struct Listener::Impl {
  struct SharedLink {
    std::string identity;
    std::unique_ptr<SharedMemory> memory;
  };
  /// All that is known of who has said something.
  struct Sender {
    std::string name;              ///< whose key it has
    int descriptor = -1;           ///< of its connection
    std::uint64_t connection = 0;  ///< number by which the door knows it
    std::size_t limit = first_message_limit;
  };

  explicit Impl(const std::vector<std::string>& participants) : door(context, socket, participants) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { zmq_socket_monitor(socket.handle(), nullptr, 0); }  // before `door`: its events would have nowhere to go

  /// Null for who shares no memory.
  [[nodiscard]] const SharedLink* link_to(const std::string& whose) const {
    const auto is_to = [&](const SharedLink& link) { return link.identity == whose; };
    const auto found = std::find_if(links.begin(), links.end(), is_to);
    return found == links.end() ? nullptr : &*found;
  }
  bool receive_shared(const SharedLink* awaited, std::string& sender, Message& message);
  bool receive_socket(std::string& sender, Message& message);
  bool is_of_its_sender(const std::string& sender);
  /// Whether the socket, or a file that `ready` has nothing against, has something to read until then.
  enum class Look { nothing, something, closed, stop };
  Look look(Deadline until, const std::function<bool(std::size_t)>& ready);

  zmq::context_t context;
  zmq::socket_t socket = make_socket(context, zmq::socket_type::router);
  Door door;
  std::unique_ptr<PrivateFolder> folder;
  std::vector<zmq::pollitem_t> items;
  std::size_t own_items = 0;  ///< those of sockets, before those of files
  zmq::message_t identity, frame;
  Pieces pieces;
  msgpack::sbuffer buffer;
  std::vector<SharedLink> links;
  std::map<std::string, Sender> senders;
  std::string last_sender;
  Clock::time_point next_look;
};

Listener::Listener(const std::string& endpoint, const std::vector<std::string>& participants,
                   std::size_t largest_message) {
  seed_routing_ids();
  impl_ = std::make_unique<Impl>(participants);
  std::string address = endpoint;
  if (endpoint == "ipc://*") {
    impl_->folder = std::make_unique<PrivateFolder>();
    address = "ipc://" + impl_->folder->path() + "/socket";
  }
  impl_->socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(largest_message));
  try {
    impl_->socket.bind(address);
  } catch (const zmq::error_t& error) {
    refuse_endpoint(endpoint, "listen at", error);
  }
}

Listener::~Listener() {
  for (auto& link : impl_->links) link.memory->flush_all();
}

const ParticipantKey& Listener::key_of(const std::string& name) const { return impl_->door.key_of(name); }

const std::string& Listener::sender() const { return impl_->senders[impl_->last_sender].name; }

void Listener::close_door() {
  impl_->door.close();
  impl_->folder.reset();
}

std::uint64_t Listener::closings() const { return impl_->door.closings(); }

bool Listener::gone(const std::string& identity) const {
  const auto& sender = impl_->senders[identity];
  return impl_->door.connection(sender.descriptor) != sender.connection || sender.connection == 0;
}

void Listener::limit(const std::string& identity, std::size_t bytes) {
  impl_->senders[identity].limit = bytes;
  if (const auto* link = impl_->link_to(identity)) link->memory->receiver().limit(bytes);
}

std::string Listener::endpoint() const { return impl_->socket.get(zmq::sockopt::last_endpoint); }

void Listener::share(const std::string& identity, std::unique_ptr<SharedMemory> memory) {
  memory->receiver().limit(impl_->senders[identity].limit);
  impl_->links.push_back({identity, std::move(memory)});
}

bool Listener::receive(std::string& identity, Message& message, Deadline deadline,
                       const std::vector<int>& file_descriptors, const std::function<bool(std::size_t)>& ready) {
  auto& items = impl_->items;
  items.clear();
  impl_->door.add_items(items);
  items.push_back({impl_->socket.handle(), 0, ZMQ_POLLIN, 0});
  impl_->own_items = items.size();
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
      // A peer that closed its connection may have left last words.
      if (seen == Impl::Look::closed)
        return impl_->receive_socket(identity, message) || impl_->receive_shared(awaited, identity, message);
      if (seen == Impl::Look::something && impl_->receive_socket(identity, message)) return true;
    }
    if (impl_->receive_shared(awaited, identity, message)) return true;
    if (Clock::now() >= deadline) return false;
    if (awaited) awaited->memory->wait(std::min(deadline, impl_->next_look));
  }
}

/// A message that has come through shared memory; `sender` is set before an error can be that of a peer.
bool Listener::Impl::receive_shared(const SharedLink* awaited, std::string& sender, Message& message) {
  const auto take = [&](const SharedLink& link) {
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
  last_sender.assign(identity.data<char>(), identity.size());
  // The frames of a message come together; one of an identity alone is not one of ours.
  const bool whole = identity.more() && receive_frame(socket, frame);
  if (!is_of_its_sender(last_sender)) {
    while (frame.more() && receive_frame(socket, frame)) {
    }
    return false;
  }
  sender = last_sender;
  if (!whole) throw ProtocolError("the peer sent no message");
  const auto limit = senders[sender].limit;
  if (frame.size() > limit) {
    throw ProtocolError(fmt::format("the peer sent a message of {} bytes, allowed are {}", frame.size(), limit));
  }
  decode_frame(socket, frame, "the peer", message);
  return true;
}

/// False if another connection has come to the name of who spoke first under it. Last words of who is gone may be read
/// when its descriptor belongs to the next one that came: they are its own if its key opened no other connection.
bool Listener::Impl::is_of_its_sender(const std::string& who) {
  const int descriptor = frame.get(ZMQ_SRCFD);
  auto [found, is_new] = senders.try_emplace(who);
  auto& known = found->second;
  if (is_new || known.descriptor < 0) {
    known.descriptor = descriptor;
    known.connection = door.note_message(descriptor);
    if (door.has_keys()) known.name = frame.gets("User-Id");
    return true;
  }
  if (descriptor != known.descriptor) return false;
  const auto now = door.connection(descriptor);
  if (now == known.connection || now == 0) return true;
  return door.has_keys() && frame.gets("User-Id") == known.name && door.let_in_once(known.name);
}

Listener::Impl::Look Listener::Impl::look(Deadline until, const std::function<bool(std::size_t)>& ready) {
  door.end_pause();
  if (!poll(items, until)) return Look::nothing;
  const auto closings = door.closings();
  if (std::any_of(items.begin(), items.begin() + door_items, [](const auto& item) { return item.revents != 0; }))
    door.attend();
  if (door.closings() != closings) return Look::closed;
  for (std::size_t i = own_items; i < items.size(); ++i) {
    if (items[i].revents != 0 && !ready(i - own_items)) return Look::stop;
  }
  return Look::something;
}

void Listener::send(const std::string& identity, const Message& message) {
  require_finite(message);
  if (const auto* link = impl_->link_to(identity)) {
    encode(message, impl_->pieces);
    link->memory->sender().send(impl_->pieces.in_order());
    return;
  }
  encode(message, impl_->buffer);
  send_frame(impl_->socket, identity.data(), identity.size(), zmq::send_flags::sndmore);
  send_frame(impl_->socket, impl_->buffer.data(), impl_->buffer.size(), zmq::send_flags::none);
}

}  // namespace ricochet::wire
