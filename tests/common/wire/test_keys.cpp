// Keys, the door, and how large messages may be.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/base/error.hpp"
#include "common/wire/channel.hpp"
#include "tests/support/private_endpoint.hpp"

namespace ricochet::wire {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

std::string file(const std::string& text) {
  const std::string path = testing::TempDir() + "key_" + std::to_string(getpid());
  std::ofstream(path) << text;
  return path;
}

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

Message hello(std::size_t text_size = 0) {
  Message message;
  message.kind = Kind::hello;
  message.as<Hello>().participant = "a";
  message.as<Hello>().solver = std::string(text_size, 'x');
  return message;
}

/// The name by which the listener knows who spoke; "nobody" if nothing came.
std::string heard(Listener& listener, double within_s = 5.0) {
  std::string identity;
  Message message;
  return listener.receive(identity, message, deadline_in(within_s), {}, {}) ? listener.sender() : "nobody";
}

TEST(Keys, AreReadAsTheyWereWritten) {
  const ParticipantKey key{make_key_pair().public_key, make_key_pair()};
  const auto again = read_key(file(to_text(key)), 0.0);
  EXPECT_EQ(again.coupler_public_key, key.coupler_public_key);
  EXPECT_EQ(again.own.public_key, key.own.public_key);
  EXPECT_EQ(again.own.secret_key, key.own.secret_key);
  EXPECT_NE(make_key_pair().secret_key, make_key_pair().secret_key);
}

TEST(Keys, AFileThatHoldsNoneIsNamed) {
  for (const std::string text : {"", "coupler short\n", "public x\n", "\xff\xfe"}) {
    EXPECT_THAT(error_of([&] { static_cast<void>(read_key(file(text), 0.0)); }), HasSubstr("is no key of a run"));
  }
  EXPECT_THAT(error_of([] { static_cast<void>(read_key("/nonexistent/key", 0.1)); }),
              HasSubstr("cannot read /nonexistent/key"));
}

TEST(Door, TellsWhoseKeyASenderHas) {
  Listener listener("ipc://*", {"a", "b"});
  Channel b(listener.endpoint(), listener.key_of("b")), a(listener.endpoint(), listener.key_of("a"));
  b.send(hello());
  EXPECT_EQ(heard(listener), "b");
  a.send(hello());
  EXPECT_EQ(heard(listener), "a");
}

TEST(Door, NobodyElseGetsAByteThrough) {
  Listener listener("tcp://127.0.0.1:*", {"a"});
  auto wrong = listener.key_of("a");
  wrong.own = make_key_pair();
  Channel without(listener.endpoint()), stranger(listener.endpoint(), wrong);
  auto other_coupler = listener.key_of("a");
  other_coupler.coupler_public_key = make_key_pair().public_key;
  Channel misled(listener.endpoint(), other_coupler);
  for (auto* channel : {&without, &stranger, &misled}) channel->send(hello());
  EXPECT_EQ(heard(listener, 0.5), "nobody");
  Message message;
  EXPECT_THAT(error_of([&] { stranger.receive(message, deadline_in(5.0), false); }),
              HasSubstr("it does not know this key"));
}

TEST(Door, SocketLiesInAFolderOfThisUserAlone) {
  std::string folder;
  {
    Listener listener("ipc://*", {"a"});
    const auto path = fs::path(listener.endpoint().substr(6));
    folder = path.parent_path().string();
    EXPECT_EQ(fs::status(folder).permissions(), fs::perms::owner_all);
    Channel channel(listener.endpoint(), listener.key_of("a"));
    channel.send(hello());
    EXPECT_EQ(heard(listener), "a");
    listener.close_door();
    EXPECT_FALSE(fs::exists(folder)) << "nothing is left behind, even by a coupler that is killed";
    channel.send(hello());
    EXPECT_EQ(heard(listener), "a") << "who is in stays in";
  }
  EXPECT_FALSE(fs::exists(folder));
}

TEST(Door, ClosedItLetsNobodyInAnyMore) {
  Listener listener("tcp://127.0.0.1:*", {"a", "b"});
  Channel first(listener.endpoint(), listener.key_of("a"));
  first.send(hello());
  EXPECT_EQ(heard(listener), "a");
  listener.close_door();
  Channel late(listener.endpoint(), listener.key_of("b"));
  late.send(hello());
  EXPECT_EQ(heard(listener, 0.5), "nobody");
  first.send(hello());
  EXPECT_EQ(heard(listener), "a");
}

TEST(Door, ClosedConnectionsAreTold) {
  Listener listener("ipc://*", {"a"});
  std::string identity;
  Message message;
  {
    Channel channel(listener.endpoint(), listener.key_of("a"));
    channel.send(hello());
    ASSERT_TRUE(listener.receive(identity, message, deadline_in(5.0), {}, {}));
    EXPECT_FALSE(listener.gone(identity));
    EXPECT_EQ(listener.closings(), 0U);
  }
  std::string nobody;
  EXPECT_FALSE(listener.receive(nobody, message, deadline_in(5.0), {}, {}));
  EXPECT_EQ(listener.closings(), 1U);
  EXPECT_TRUE(listener.gone(identity));
}

/// A connection from outside, of somebody who says nothing.
class SilentConnection {
 public:
  SilentConnection() = default;
  SilentConnection(const SilentConnection&) = delete;
  SilentConnection& operator=(const SilentConnection&) = delete;
  ~SilentConnection() { close(socket_); }
  /// False if nobody takes it at once.
  bool connect_to(const Listener& listener) const {
    const auto endpoint = listener.endpoint();
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1))));
    connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    pollfd ready{socket_, POLLOUT, 0};
    return poll(&ready, 1, 100) == 1 && (ready.revents & POLLERR) == 0;
  }

 private:
  int socket_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
};

/// The kernel gives the number of a connection that was closed to the next one that comes.
TEST(Door, LastWordsAreHeardThoughAStrangerCameInTheirSendersPlace) {
  Listener listener("tcp://127.0.0.1:*", {"a", "b"});
  std::deque<SilentConnection> strangers(40);
  Channel b(listener.endpoint(), listener.key_of("b"));
  {
    Channel a(listener.endpoint(), listener.key_of("a"));
    a.send(hello());
    ASSERT_EQ(heard(listener), "a");
    ASSERT_EQ(heard(listener, 0.3), "nobody");  // b is let in meanwhile
    b.send(hello());                            // which makes the listener look who came and went
    a.send(hello());
    a.send(hello());
  }
  for (const auto& stranger : strangers) stranger.connect_to(listener);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // all of it waits to be read
  std::vector<std::string> speakers;
  for (int message = 0; message < 3; ++message) speakers.push_back(heard(listener, 1.0));
  EXPECT_THAT(speakers, testing::UnorderedElementsAre("a", "a", "b"));
}

TEST(Door, ClosedItTakesFewConnectionsUntilAWhileIsOver) {
  Listener listener("tcp://127.0.0.1:*", {"a"});
  Channel channel(listener.endpoint(), listener.key_of("a"));
  channel.send(hello());
  ASSERT_EQ(heard(listener), "a");
  listener.close_door();
  std::deque<SilentConnection> strangers(200);
  const auto refused = std::find_if(strangers.begin(), strangers.end(), [&](const auto& stranger) {
    const bool taken = stranger.connect_to(listener);
    heard(listener, 0.005);
    return !taken;
  });
  EXPECT_NE(refused, strangers.end()) << "all were taken";
  channel.send(hello());
  EXPECT_EQ(heard(listener), "a") << "who is in stays in";
  for (int look = 0; look < 12; ++look) EXPECT_EQ(heard(listener, 0.1), "nobody");
  EXPECT_TRUE(SilentConnection().connect_to(listener)) << "and is told that the door is closed";
}

TEST(Limits, OfMessagesBeforeAndAfterTheFirstOne) {
  Listener listener("ipc://*", {"a"});
  Channel channel(listener.endpoint(), listener.key_of("a"));
  channel.send(hello(first_message_limit));
  EXPECT_THAT(error_of([&] { heard(listener); }), HasSubstr("bytes, allowed are 65536"));
  std::string identity;
  Message message;
  channel.send(hello());
  ASSERT_TRUE(listener.receive(identity, message, deadline_in(5.0), {}, {}));
  listener.limit(identity, 2 * first_message_limit);
  channel.send(hello(first_message_limit));
  EXPECT_EQ(heard(listener), "a");
  channel.send(hello(3 * first_message_limit));
  EXPECT_THAT(error_of([&] { heard(listener); }), HasSubstr("allowed are 131072"));
}

TEST(Limits, OfAWholeListenerCloseTheConnection) {
  Listener listener("ipc://*", {"a"}, 100'000);
  Channel channel(listener.endpoint(), listener.key_of("a"));
  channel.send(hello(200'000));
  EXPECT_EQ(heard(listener, 0.5), "nobody");
  Message message;
  EXPECT_THAT(error_of([&] { channel.receive(message, deadline_in(5.0), false); }), HasSubstr("closed the connection"));
}

}  // namespace
}  // namespace ricochet::wire
