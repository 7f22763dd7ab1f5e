// How serve() ends when the other side is wrong, fails, dies, or is not there at all.
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <future>
#include <zmq.hpp>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/private_endpoint.hpp"
#include "tests/support/spring_mass.hpp"

namespace ricochet::participant {
namespace {

using testing::HasSubstr;
using wire::Kind;
using wire::Message;

TEST(ServeAlone, RefusesBytesThatAreNoMessage) {
  const std::string endpoint = private_endpoint();
  zmq::context_t context;
  zmq::socket_t coupler(context, zmq::socket_type::router);
  coupler.bind(endpoint);
  SpringMass spring;
  testing::internal::CaptureStderr();
  auto exit_code = std::async(std::launch::async, [&] { return serve(spring, {endpoint, 10.0, false}); });
  zmq::message_t identity, hello, failure;
  ASSERT_TRUE(coupler.recv(identity) && coupler.recv(hello));
  coupler.send(identity, zmq::send_flags::sndmore);
  coupler.send(zmq::str_buffer("welcome!"), zmq::send_flags::none);
  ASSERT_TRUE(coupler.recv(identity) && coupler.recv(failure));
  Message message;
  wire::decode(failure.to_string_view(), "spring", message);
  EXPECT_EQ(message.kind, Kind::failure);
  EXPECT_THAT(message.as<wire::Failure>().error_text, HasSubstr("the coupler sent an integer, expected a message"));
  EXPECT_EQ(exit_code.get(), 5);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("spring: error: the coupler sent an integer"));
}

TEST(ServeAlone, EndsAtTheFailureOfTheCouplerWithItsCode) {
  for (const int code : {2, 3, 4, 5}) {
    SpringMass spring;
    OverSocket peer(private_endpoint());
    testing::internal::CaptureStderr();
    auto exit_code = std::async(std::launch::async, [&] {
      return serve(spring, {peer.listener.endpoint(), 10.0, false});
    });
    peer.meet();
    peer.coupler.start();
    auto message = peer.coupler.request(Kind::failure);
    message.as<wire::Failure>().error_code = code;
    message.as<wire::Failure>().error_culprit = "other";
    message.as<wire::Failure>().error_text = "participant 'other' was killed";
    peer.say(message);
    EXPECT_EQ(exit_code.get(), code);
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "spring: error: the coupler ended the run: participant 'other' was killed\n");
    EXPECT_THROW(peer.hear(0.05), std::runtime_error) << "a failure is not answered";
  }
}

TEST(ServeAlone, EndsWhenTheCouplerDies) {
  SpringMass spring;
  auto peer = std::make_unique<OverSocket>(private_endpoint());
  testing::internal::CaptureStderr();
  auto exit_code = std::async(std::launch::async, [&spring, endpoint = peer->listener.endpoint()] {
    return serve(spring, {endpoint, 60.0, false});
  });
  peer->meet();
  peer->coupler.start();
  peer.reset();
  ASSERT_EQ(exit_code.wait_for(std::chrono::seconds(5)), std::future_status::ready);
  EXPECT_EQ(exit_code.get(), 4);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("spring: error: the coupler is gone"));
}

TEST(ServeAlone, ReportsAnAddressThatIsNone) {
  SpringMass spring;
  testing::internal::CaptureStderr();
  EXPECT_EQ(serve(spring, {"nowhere", 1.0, false}), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("spring: error: cannot connect to 'nowhere'"));
}

class Mute : public SpringMass {
  Description describe() override { throw ConfigError("scene.toml: no participant 'sprng'"); }
};

TEST(ServeAlone, ReportsAParticipantThatCannotDescribeItself) {
  Mute mute;
  testing::internal::CaptureStderr();
  EXPECT_EQ(serve(mute, {private_endpoint(), 1.0, false}), 2);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "participant: error: scene.toml: no participant 'sprng'\n");
}

/// serve() in a process of its own, whose standard input is a pipe that the test holds.
TEST(ServeAlone, EndsAtOnceWhenStandardInputCloses) {
  const std::string endpoint = private_endpoint();
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  testing::internal::CaptureStderr();
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[0], STDIN_FILENO);
    close(ends[0]);
    close(ends[1]);
    SpringMass spring;
    _exit(serve(spring, {endpoint, 60.0, true}));
  }
  close(ends[0]);
  OverSocket peer(endpoint);
  peer.meet();
  ASSERT_EQ(write(ends[1], "x", 1), 1);  // input that nobody reads is not the end of it
  peer.coupler.start();
  peer.coupler.ask(peer.coupler.advance(0.0));
  const auto begin = wire::Clock::now();
  close(ends[1]);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_LT(wire::Clock::now() - begin, std::chrono::seconds(3));
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 4);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("spring: error: window 1: the coupler is gone: standard input was closed"));
  EXPECT_THROW(static_cast<void>(peer.hear()), std::runtime_error) << "why it ended says what started it";
}

}  // namespace
}  // namespace ricochet::participant
