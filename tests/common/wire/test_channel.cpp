#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <future>
#include <thread>
#include <zmq.hpp>

#include "common/base/error.hpp"
#include "common/wire/channel.hpp"
#include "tests/common/wire/samples.hpp"
#include "tests/support/private_endpoint.hpp"

namespace ricochet::wire {
namespace {

using testing::HasSubstr;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

bool receive(Listener& listener, std::string& identity, Message& message, double timeout_s = 10.0) {
  return listener.receive(identity, message, deadline_in(timeout_s), {}, [](std::size_t) { return true; });
}

/// `sample`, but nobody here has offered shared memory.
Message over_socket(Kind kind) {
  Message message = sample(kind);
  if (kind == Kind::welcome) message.as<Welcome>().shared_memory = false;
  return message;
}

template <class Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

class OverEveryTransport : public testing::TestWithParam<std::string> {
 protected:
  static std::string endpoint() {
    if (GetParam() == "abstract") return private_endpoint();
    if (GetParam() == "tcp") return "tcp://127.0.0.1:*";
    return "ipc://" + (std::filesystem::temp_directory_path() / ("ricochet-" + std::to_string(getpid()))).string();
  }
};

TEST_P(OverEveryTransport, MessagesOfEveryKindGoThereAndBack) {
  Listener listener(endpoint());
  auto participant = std::async(std::launch::async, [&listener] {
    Channel channel(listener.endpoint());
    Message message;
    channel.send(sample(Kind::hello));
    for (std::size_t n = 0; n < all_kinds().size(); ++n) {
      channel.receive(message, deadline_in(10), false);
      channel.send(message);
    }
  });
  std::string identity;
  Message message;
  ASSERT_TRUE(receive(listener, identity, message));
  EXPECT_EQ(message.kind, Kind::hello);
  for (const Kind kind : all_kinds()) {
    listener.send(identity, over_socket(kind));
    ASSERT_TRUE(receive(listener, identity, message));
    expect_same(message, over_socket(kind));
  }
  participant.get();
}

TEST_P(OverEveryTransport, TheParticipantMayBeThereFirst) {
  const std::string where = Listener(endpoint()).endpoint();  // free again at once
  Channel channel(where);
  channel.send(sample(Kind::hello));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  Listener listener(where);
  std::string identity;
  Message message;
  EXPECT_TRUE(receive(listener, identity, message));
}

TEST_P(OverEveryTransport, TheLastWordsGetOut) {
  Listener listener(endpoint());
  {
    Channel channel(listener.endpoint());
    channel.send(sample(Kind::failure));
  }
  std::string identity;
  Message message;
  ASSERT_TRUE(receive(listener, identity, message));
  EXPECT_EQ(message.kind, Kind::failure);
}

TEST_P(OverEveryTransport, AParticipantNoticesAtOnceThatTheCouplerIsGone) {
  auto listener = std::make_unique<Listener>(endpoint());
  Channel channel(listener->endpoint());
  channel.send(sample(Kind::hello));
  std::string identity;
  Message message;
  ASSERT_TRUE(receive(*listener, identity, message));
  listener->send(identity, sample(Kind::failure));
  const auto begin = Clock::now();
  listener.reset();
  channel.receive(message, deadline_in(10), false);  // its last words come first
  EXPECT_EQ(message.kind, Kind::failure);
  EXPECT_THAT(error_of([&] { channel.receive(message, deadline_in(10), false); }),
              HasSubstr("the coupler is gone: it closed the connection"));
  EXPECT_LT(seconds_since(begin), 2.0);
}

INSTANTIATE_TEST_SUITE_P(Channel, OverEveryTransport, testing::Values("abstract", "file", "tcp"),
                         [](const auto& param_info) { return param_info.param; });

TEST(Listener, TellsParticipantsApart) {
  Listener listener(private_endpoint());
  Channel a(listener.endpoint()), b(listener.endpoint());
  Message message = sample(Kind::hello);
  std::map<std::string, std::string> identity_of;
  for (auto* channel : {&a, &b}) {
    message.as<Hello>().participant = channel == &a ? "a" : "b";
    channel->send(message);
  }
  for (int n = 0; n < 2; ++n) {
    std::string identity;
    ASSERT_TRUE(receive(listener, identity, message));
    identity_of[message.as<Hello>().participant] = identity;
  }
  for (const std::string name : {"b", "a"}) {
    message = over_socket(Kind::welcome);
    message.as<Welcome>().participant = name;
    listener.send(identity_of.at(name), message);
  }
  a.receive(message, deadline_in(10), false);
  EXPECT_EQ(message.as<Welcome>().participant, "a");
  b.receive(message, deadline_in(10), false);
  EXPECT_EQ(message.as<Welcome>().participant, "b");
}

TEST(Listener, SendingToWhoIsGoneDoesNothing) {
  Listener listener(private_endpoint());
  std::string identity;
  Message message;
  {
    Channel channel(listener.endpoint());
    channel.send(sample(Kind::hello));
    ASSERT_TRUE(receive(listener, identity, message));
  }
  EXPECT_FALSE(receive(listener, identity, message, 0.05));
  EXPECT_NO_THROW(listener.send(identity, sample(Kind::welcome)));
  EXPECT_NO_THROW(listener.send("nobody", sample(Kind::welcome)));
}

TEST(Listener, WakesUpForOtherFiles) {
  Listener listener(private_endpoint());
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  std::string identity;
  Message message;
  int calls = 0;
  const auto wait = [&](bool go_on) {
    return listener.receive(identity, message, deadline_in(go_on ? 0.05 : 10), {ends[0]}, [&](std::size_t index) {
      EXPECT_EQ(index, 0U);
      char byte = 0;
      EXPECT_EQ(read(ends[0], &byte, 1), 1);
      ++calls;
      return go_on;
    });
  };
  ASSERT_EQ(write(ends[1], "x", 1), 1);
  auto begin = Clock::now();
  EXPECT_FALSE(wait(false));
  EXPECT_LT(seconds_since(begin), 1.0);
  ASSERT_EQ(write(ends[1], "x", 1), 1);
  begin = Clock::now();
  EXPECT_FALSE(wait(true));
  EXPECT_GE(seconds_since(begin), 0.05);
  EXPECT_EQ(calls, 2);
  close(ends[0]);
  close(ends[1]);
}

TEST(Listener, NamesThePortThatWasPicked) {
  EXPECT_THAT(Listener("tcp://127.0.0.1:*").endpoint(), testing::MatchesRegex("tcp://127.0.0.1:[0-9]+"));
}

TEST(Listener, TwoAtOneAddressIsAnError) {
  Listener first("tcp://127.0.0.1:*");
  EXPECT_THROW(Listener second(first.endpoint()), ConfigError);
}

TEST(Listener, RefusesMessagesOfSeveralFramesAndGoesOn) {
  Listener listener(private_endpoint());
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::dealer);
  socket.connect(listener.endpoint());
  const std::string good = encoded(sample(Kind::hello));
  socket.send(zmq::buffer(good), zmq::send_flags::sndmore);
  socket.send(zmq::buffer(good), zmq::send_flags::sndmore);
  socket.send(zmq::buffer(good), zmq::send_flags::none);
  socket.send(zmq::str_buffer("nonsense"), zmq::send_flags::none);
  socket.send(zmq::buffer(good), zmq::send_flags::none);
  std::string first, second, third;
  Message message;
  EXPECT_THAT(error_of([&] { receive(listener, first, message); }), HasSubstr("a message of 3 frames, expected one"));
  EXPECT_THAT(error_of([&] { receive(listener, second, message); }), HasSubstr("the peer sent"));
  EXPECT_TRUE(receive(listener, third, message));
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(first, second);
  EXPECT_EQ(first, third);
}

TEST(Listener, DoesNotMindSomeoneWhoSpeaksNoZeroMq) {
  Listener listener("tcp://127.0.0.1:*");
  const std::string where = listener.endpoint();
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(where.substr(where.rfind(':') + 1))));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int stranger = socket(AF_INET, SOCK_STREAM, 0);
  ASSERT_EQ(connect(stranger, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const std::string request = "GET / HTTP/1.1\r\n\r\n" + std::string(1000, '\xff');
  ASSERT_EQ(send(stranger, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
  std::string identity;
  Message message;
  EXPECT_FALSE(receive(listener, identity, message, 0.1));
  Channel channel(where);
  channel.send(sample(Kind::hello));
  EXPECT_TRUE(receive(listener, identity, message));
  close(stranger);
}

TEST(Channel, SaysAtTheDeadlineThatTheCouplerIsSilent) {
  Listener silent(private_endpoint());
  Channel channel(silent.endpoint());
  Message message;
  const auto begin = Clock::now();
  EXPECT_THAT(error_of([&] { channel.receive(message, deadline_in(0.2), false); }),
              HasSubstr("the coupler has not answered within 0.2 s"));
  EXPECT_GE(seconds_since(begin), 0.2);
  EXPECT_LT(seconds_since(begin), 1.0);
}

TEST(Channel, WaitsNoLongerForACouplerThatNeverComes) {
  const auto begin = Clock::now();
  {
    Channel channel(private_endpoint());
    channel.send(sample(Kind::hello));
    Message message;
    EXPECT_THROW(channel.receive(message, deadline_in(0.1), false), ParticipantError);
  }
  EXPECT_LT(seconds_since(begin), 2.0);  // the unsent hello lingers half a second
}

TEST(Channel, RefusesAddressesThatAreNone) {
  for (const std::string endpoint : {"", "localhost", "http://localhost:80", "tcp://127.0.0.1", "ipc://"}) {
    EXPECT_THAT(error_of([&] { Channel channel(endpoint); }), HasSubstr("expected ipc://@name")) << endpoint;
    EXPECT_THROW(Listener listener(endpoint), ConfigError) << endpoint;
  }
}

TEST(Listener, DoesNotSendNumbersThatAreNotFinite) {
  Listener listener(private_endpoint());
  Message message = sample(Kind::welcome);
  message.as<Welcome>().timeout_s = HUGE_VAL;
  EXPECT_THROW(listener.send("a peer", message), SolverError);
}

TEST(DeadlineIn, KeepsToWhatAClockCanHold) {
  EXPECT_LE(deadline_in(-5), Clock::now() + std::chrono::seconds(1));
  EXPECT_LE(deadline_in(std::nan("")), Clock::now() + std::chrono::seconds(1));
  EXPECT_GT(deadline_in(1e300), Clock::now() + std::chrono::hours(24));
}

}  // namespace
}  // namespace ricochet::wire
