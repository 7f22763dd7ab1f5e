// Peers against participants that are threads of this program on a real socket, and processes that are not
// participants.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <thread>

#include "common/base/error.hpp"
#include "coupler/processes/interrupted.hpp"
#include "coupler/processes/peers.hpp"
#include "coupler/processes/run_id.hpp"

namespace ricochet::coupler {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using wire::Kind;
using wire::Message;

const std::string this_scene(64, 'c'), another_scene(64, 'b');

wire::Deadline in(double seconds) {
  return wire::Clock::now() + std::chrono::milliseconds(static_cast<int>(1000 * seconds));
}

/// A participant on its own socket.
class Client {
 public:
  explicit Client(const std::string& endpoint) : channel_(endpoint) {}

  void send(Message message) {
    message.sequence = sequence_++;
    message.run_id = run_id_;
    channel_.send(message);
  }
  enum class Offer { nothing, memory, wrong_memory };
  void hello(const std::string& name, const std::string& role, const std::string& sha = "",
             Offer offer = Offer::nothing) {
    Message message;
    auto& hello = message.make<wire::Hello>();
    if (offer != Offer::nothing) channel_.offer_shared_memory(hello);
    if (offer == Offer::wrong_memory) ++hello.shared_memory_key;
    hello.participant = name;
    hello.role = role;
    hello.scene_sha256 = sha;
    hello.process_id = 4711;
    send(message);
  }
  Message receive() {
    Message message;
    channel_.receive(message, in(10), false);
    run_id_ = message.run_id;
    return message;
  }
  void answer(Kind kind) {
    Message message;
    message.kind = kind;
    send(message);
  }

 private:
  wire::Channel channel_;
  std::string run_id_;
  std::int64_t sequence_ = 0;
};

class PeersTest : public testing::Test {
 protected:
  std::string folder_ = testing::TempDir() + "peers_" + std::to_string(getpid());
  std::string run_id_ = make_run_id();
  Launcher launcher_;
  wire::Listener listener_{"ipc://@ricochet-test-" + run_id_};
  Peers peers_{listener_,
               launcher_,
               {{"explicit", Role::explicit_solver}, {"implicit", Role::implicit_solver}},
               {run_id_, this_scene, 1.0, 1e-6}};

  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string endpoint() { return listener_.endpoint(); }
  void launch(const std::string& name, const std::string& script) {
    launcher_.launch({name, "/bin/sh", {"-c", script}, folder_ + "/" + name + ".log"});
  }
  /// Text and exit code of what ends `action`.
  static std::pair<int, std::string> failure(const std::function<void()>& action) {
    try {
      action();
    } catch (const Error& error) {
      return {static_cast<int>(error.code()), error.what()};
    } catch (const Interrupted& error) {
      return {error.exit_code(), error.what()};
    }
    return {0, ""};
  }
  void describe(std::size_t index) {
    Message message;
    message.kind = Kind::describe;
    peers_.peer(index).post(message);
  }
};

TEST_F(PeersTest, EveryoneIsWelcomedAndStrangersAreTurnedAwayWithTheReason) {
  Client stranger(endpoint()), other_scene(endpoint()), wrong_role(endpoint()), first(endpoint()), second(endpoint()),
      twin(endpoint());
  stranger.hello("explict", "explicit");
  other_scene.hello("explicit", "explicit", another_scene);
  wrong_role.hello("explicit", "implicit");
  std::string trouble;
  std::jthread meeting([&] { trouble = failure([&] { peers_.handshake(); }).second; });
  EXPECT_THAT(stranger.receive().as<wire::Failure>().error_text,
              AllOf(HasSubstr("'explict'"), HasSubstr("explicit, implicit"), HasSubstr("did you mean \"explicit\"")));
  EXPECT_THAT(other_scene.receive().as<wire::Failure>().error_text, HasSubstr("another scene"));
  EXPECT_THAT(wrong_role.receive().as<wire::Failure>().error_text, HasSubstr("says it is implicit"));
  first.hello("explicit", "explicit", this_scene);
  EXPECT_EQ(first.receive().kind, Kind::welcome);
  twin.hello("explicit", "explicit");
  EXPECT_THAT(twin.receive().as<wire::Failure>().error_text, HasSubstr("already takes part"));
  second.hello("implicit", "implicit");
  const auto welcome = second.receive();
  meeting.join();
  EXPECT_EQ(trouble, "");
  EXPECT_EQ(welcome.run_id, run_id_);
  EXPECT_EQ(peers_.process_id(0), 4711);
}

TEST_F(PeersTest, NoHelloWithinTheDeadlineNamesWhoIsMissing) {
  Client first(endpoint());
  first.hello("explicit", "explicit");
  const auto [code, text] = failure([&] { peers_.handshake(); });
  EXPECT_EQ(code, 4);
  EXPECT_THAT(text, AllOf(HasSubstr("'implicit'"), HasSubstr("within 1 s")));
}

TEST_F(PeersTest, DeathBeforeHelloIsNoticedAtOnceWithTheLog) {
  launch("implicit", "echo cannot find the mesh; exit 7");
  const auto begin = wire::Clock::now();
  const auto [code, text] = failure([&] { peers_.handshake(); });
  EXPECT_LT(wire::Clock::now() - begin, std::chrono::milliseconds(900));
  EXPECT_EQ(code, 4);
  EXPECT_THAT(text, AllOf(HasSubstr("'implicit'"), HasSubstr("exit code 7"), HasSubstr("before it said hello"),
                          HasSubstr("cannot find the mesh")));
}

/// The answer of a run's transport to a participant that offers shared memory, of one that does not, and of one that
/// offers what is not its own.
TEST_F(PeersTest, SharedMemoryIsTakenWhereItIsOfferedAndWanted) {
  using Offer = Client::Offer;
  for (const auto& [wanted, expected_first, expected_second] :
       {std::tuple{Transport::automatic, Transport::shm, Transport::zmq},
        {Transport::zmq, Transport::zmq, Transport::zmq},
        {Transport::tcp, Transport::tcp, Transport::tcp}}) {
    for (const auto offer : {Offer::nothing, Offer::wrong_memory}) {
      wire::Listener listener("ipc://@ricochet-test-" + make_run_id());
      Peers peers(listener, launcher_, {{"explicit", Role::explicit_solver}, {"implicit", Role::implicit_solver}},
                  {run_id_, this_scene, 10.0, 1e-6, wanted, ""});
      Client first(listener.endpoint()), second(listener.endpoint());
      first.hello("explicit", "explicit", "", Offer::memory);
      second.hello("implicit", "implicit", "", offer);
      peers.handshake();
      EXPECT_EQ(peers.transport(0), expected_first);
      EXPECT_EQ(peers.transport(1), expected_second);
      EXPECT_EQ(first.receive().as<wire::Welcome>().shared_memory, peers.transport(0) == Transport::shm);
      EXPECT_FALSE(second.receive().as<wire::Welcome>().shared_memory);
    }
  }
}

TEST_F(PeersTest, WhoCannotHaveTheSharedMemoryThatIsRequiredIsTurnedAway) {
  Peers peers(listener_, launcher_, {{"explicit", Role::explicit_solver}},
              {run_id_, this_scene, 10.0, 1e-6, Transport::shm, "a.toml:7: x"});
  Client without(endpoint()), with_another(endpoint()), with(endpoint());
  std::jthread meeting([&] { peers.handshake(); });
  without.hello("explicit", "explicit");
  EXPECT_EQ(
      without.receive().as<wire::Failure>().error_text,
      "a.toml:7: x: found \"shm\", which participant 'explicit' cannot have: it offers no shared memory; \"auto\" "
      "allows ZeroMQ for it");
  with_another.hello("explicit", "explicit", "", Client::Offer::wrong_memory);
  EXPECT_THAT(with_another.receive().as<wire::Failure>().error_text,
              HasSubstr("cannot be opened: it is that of another process"));
  with.hello("explicit", "explicit", "", Client::Offer::memory);
  EXPECT_EQ(with.receive().kind, Kind::welcome);
}

/// Two participants, both through shared memory or both over ZeroMQ.
class Connected : public PeersTest, public testing::WithParamInterface<Client::Offer> {
 protected:
  std::unique_ptr<Client> explicit_, implicit_;
  void SetUp() override {
    PeersTest::SetUp();
    explicit_ = std::make_unique<Client>(endpoint());
    implicit_ = std::make_unique<Client>(endpoint());
    explicit_->hello("explicit", "explicit", "", GetParam());
    implicit_->hello("implicit", "implicit", "", GetParam());
    peers_.handshake();
    (void)explicit_->receive();
    (void)implicit_->receive();
  }
};

TEST_P(Connected, AnswersInAnyOrderReachWhoWaits) {
  describe(0);
  describe(1);
  (void)explicit_->receive();
  (void)implicit_->receive();
  implicit_->answer(Kind::description);
  explicit_->answer(Kind::description);
  EXPECT_EQ(peers_.peer(0).wait().kind, Kind::description);
  EXPECT_EQ(peers_.peer(1).wait().kind, Kind::description);
  EXPECT_EQ(peers_.wait_spans(0).size(), 1U);
}

TEST_P(Connected, SilenceIsNoticedAtTheDeadline) {
  describe(0);
  const auto [code, text] = failure([&] { (void)peers_.peer(0).wait(); });
  EXPECT_EQ(code, 4);
  EXPECT_THAT(text, AllOf(HasSubstr("'explicit' has been silent for 1."), HasSubstr("asked to 'describe'")));
}

TEST_P(Connected, FailureMessageKeepsItsExitCodeAlsoFromAnotherPeer) {
  describe(0);
  Message message;
  message.kind = Kind::failure;
  message.as<wire::Failure>().error_code = 3;
  message.as<wire::Failure>().error_text = "body 'rod': not finite";
  implicit_->send(message);
  const auto [code, text] = failure([&] { (void)peers_.peer(0).wait(); });
  EXPECT_EQ(code, 3);
  EXPECT_THAT(text, AllOf(HasSubstr("'implicit'"), HasSubstr("body 'rod': not finite")));
}

TEST_P(Connected, IllegalOrderIsAProtocolError) {
  describe(0);
  (void)explicit_->receive();
  explicit_->answer(Kind::accepted);
  const auto [code, text] = failure([&] { (void)peers_.peer(0).wait(); });
  EXPECT_EQ(code, 5);
  EXPECT_THAT(text, HasSubstr("explicit"));
}

TEST_P(Connected, DeathDuringAWaitIsNoticedAtOnce) {
  launch("explicit", "kill -9 $$");
  describe(0);
  const auto begin = wire::Clock::now();
  const auto [code, text] = failure([&] { (void)peers_.peer(0).wait(); });
  EXPECT_LT(wire::Clock::now() - begin, std::chrono::milliseconds(900));
  EXPECT_EQ(code, 4);
  EXPECT_THAT(text, AllOf(HasSubstr("'explicit' was killed by signal 9 (SIGKILL)"), HasSubstr("log")));
}

TEST_P(Connected, LastWordsOfADyingProcessCount) {
  launch("implicit", "exit 3");
  Message message;
  message.kind = Kind::failure;
  message.as<wire::Failure>().error_code = 3;
  message.as<wire::Failure>().error_text = "diverged";
  describe(0);
  usleep(100000);
  implicit_->send(message);
  const auto [code, text] = failure([&] { (void)peers_.peer(0).wait(); });
  EXPECT_EQ(code, 3);
  EXPECT_THAT(text, HasSubstr("diverged"));
}

/// A participant that has answered 'finished' may end before its answer is read; nobody is then waited for in vain.
TEST_P(Connected, EndsNoticedBeforeTheLastWordsAreRead) {
  Client* clients[] = {explicit_.get(), implicit_.get()};
  const std::pair<Kind, Kind> exchanges[] = {{Kind::describe, Kind::description},
                                             {Kind::initialize, Kind::initialized},
                                             {Kind::synchronise, Kind::synchronised},
                                             {Kind::finish, Kind::finished}};
  for (const auto& [question, answer] : exchanges) {
    for (std::size_t i = 0; i < 2; ++i) {
      Message message;
      message.kind = question;
      peers_.peer(i).post(message);
      (void)clients[i]->receive();
      clients[i]->answer(answer);
      if (question != Kind::finish) (void)peers_.peer(i).wait();
    }
  }
  launch("explicit", "exit 0");
  launch("implicit", "exit 0");
  while (launcher_.events() < 2) launcher_.poll();
  EXPECT_EQ(peers_.peer(0).wait().kind, Kind::finished);
  EXPECT_EQ(peers_.peer(1).wait().kind, Kind::finished);
}

TEST_P(Connected, CtrlCInterruptsAWait) {
  describe(0);
  std::thread user([] {
    usleep(100000);
    kill(getpid(), SIGINT);
  });
  const auto [code, text] = failure([&] { (void)peers_.peer(0).wait(); });
  user.join();
  EXPECT_EQ(code, 130);
  EXPECT_THAT(text, HasSubstr("Ctrl-C"));
}

TEST_P(Connected, FailureIsAnnouncedToEveryone) {
  peers_.announce_failure(4, "participant 'x' died", "x");
  for (auto* client : {explicit_.get(), implicit_.get()}) {
    const auto message = client->receive();
    EXPECT_EQ(message.kind, Kind::failure);
    EXPECT_EQ(message.as<wire::Failure>().error_code, 4);
    EXPECT_EQ(message.as<wire::Failure>().error_text, "participant 'x' died");
  }
}

TEST_P(Connected, IdleTimeIsAccountedToWhoWasWaitedFor) {
  describe(0);
  std::thread slow([&] {
    (void)explicit_->receive();
    usleep(200000);
    explicit_->answer(Kind::description);
  });
  (void)peers_.peer(0).wait();
  slow.join();
  EXPECT_GT(peers_.waited_for_s(0), 0.15);
  EXPECT_GT(peers_.idle_while_s(1, 0), 0.15);
  EXPECT_EQ(peers_.idle_while_s(0, 1), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Peers, Connected, testing::Values(Client::Offer::memory, Client::Offer::nothing),
                         [](const auto& test) { return test.param == Client::Offer::memory ? "shm" : "zmq"; });

}  // namespace
}  // namespace ricochet::coupler
