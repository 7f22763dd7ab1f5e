// serve() against a scripted coupler over a real socket: what it answers, says on stderr and returns.
#include <gmock/gmock.h>

#include <cmath>
#include <future>
#include <system_error>

#include "common/base/error.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/private_endpoint.hpp"
#include "tests/support/spring_mass.hpp"

namespace ricochet::participant {
namespace {

using testing::HasSubstr;
using wire::Kind;
using wire::Message;

class Serve : public testing::Test {
 protected:
  ~Serve() override {
    if (exit_code_.valid()) exit_code_.wait();
  }
  void launch(double timeout_s = 10.0) {
    testing::internal::CaptureStderr();
    exit_code_ = std::async(std::launch::async, [this, timeout_s] {
      return serve(spring_, {peer_.listener.endpoint(), timeout_s, false});
    });
  }
  /// To the first window.
  void start() {
    launch();
    peer_.meet();
    peer_.coupler.start();
  }
  /// The next message must be a failure.
  Message failure() {
    const auto& message = peer_.hear();
    EXPECT_EQ(message.kind, Kind::failure);
    return message;
  }
  /// Exit code; what was said on stderr is in `said_`.
  int end() {
    const int code = exit_code_.get();
    said_ = testing::internal::GetCapturedStderr();
    return code;
  }

  SpringMass spring_;
  OverSocket peer_{private_endpoint()};
  std::future<int> exit_code_;
  std::string said_;
};

TEST_F(Serve, RunsToTheEnd) {
  start();
  for (int n = 0; n < 100; ++n) {
    const auto& reply = peer_.coupler.ask(peer_.coupler.advance(1e-5));
    ASSERT_EQ(reply.kind, Kind::advanced);
    ASSERT_EQ(reply.window, n + 1);
    ASSERT_EQ(reply.run_id, "run-1");
    ASSERT_EQ(reply.sequence, n + 4) << "after hello, description, initialized, synchronised";
  }
  const auto& last = peer_.coupler.ask(Kind::finish);
  EXPECT_EQ(last.kind, Kind::finished);
  EXPECT_EQ(last.as<wire::Finished>().records.rows, 101) << "the start and each window";
  EXPECT_GT(last.as<wire::Finished>().compute_s, 0.0);
  EXPECT_GT(last.as<wire::Finished>().wait_s, 0.0);
  EXPECT_EQ(end(), 0);
  EXPECT_EQ(said_, "");
}

TEST_F(Serve, OverTheWireEqualsInOneProcess) {
  SpringMass other;
  InProcess direct(other, 1);
  direct.coupler.start();
  start();
  for (int n = 1; n <= 50; ++n) {
    const double increment = 1e-4 * std::sin(n) / 3.0;
    auto request = peer_.coupler.advance(increment);
    auto same = direct.coupler.advance(increment);
    request.as<wire::Advance>().absolute_requested = same.as<wire::Advance>().absolute_requested = true;
    const auto expected = direct.coupler.ask(same);
    EXPECT_EQ(peer_.coupler.ask(request).as<wire::Advanced>().absolute.data,
              expected.as<wire::Advanced>().absolute.data);
  }
  peer_.coupler.ask(Kind::finish);
  EXPECT_EQ(end(), 0);
}

TEST_F(Serve, TellsWhenTheSolverFails) {
  spring_.on_advance = [](std::int64_t window, LinkOutput&) {
    if (window == 2) throw ConfigError("the friction coefficient is missing");
  };
  start();
  peer_.coupler.ask(peer_.coupler.advance(0.0));
  peer_.say(peer_.coupler.advance(0.0));
  const auto message = failure();
  EXPECT_EQ(message.as<wire::Failure>().error_code, 2);
  EXPECT_EQ(message.as<wire::Failure>().error_culprit, "spring");
  EXPECT_EQ(message.as<wire::Failure>().error_text, "window 2: the friction coefficient is missing");
  EXPECT_EQ(message.window, 2);
  EXPECT_EQ(message.run_id, "run-1");
  EXPECT_EQ(end(), 2);
  EXPECT_EQ(said_, "spring: error: window 2: the friction coefficient is missing\n");
}

/// An error that a solver may throw, and the exit code it ends with.
struct Thrown {
  std::string name;
  std::function<void()> raise;
  int code;
  std::string says;
};

class ServeThrown : public Serve, public testing::WithParamInterface<Thrown> {};

TEST_P(ServeThrown, BecomesAFailureMessageAndAnExitCode) {
  spring_.on_advance = [](std::int64_t, LinkOutput&) { GetParam().raise(); };
  start();
  peer_.say(peer_.coupler.advance(0.0));
  const auto message = failure();
  EXPECT_EQ(message.as<wire::Failure>().error_code, GetParam().code);
  EXPECT_THAT(message.as<wire::Failure>().error_text, HasSubstr(GetParam().says));
  EXPECT_THAT(message.as<wire::Failure>().error_text, testing::Not(HasSubstr("window 1: window 1: ")));
  EXPECT_EQ(end(), GetParam().code);
  EXPECT_EQ(said_, "spring: error: " + message.as<wire::Failure>().error_text + "\n");
}

INSTANTIATE_TEST_SUITE_P(
    Errors, ServeThrown,
    testing::Values(Thrown{"config", [] { throw ConfigError("c"); }, 2, "window 1: c"},
                    Thrown{"placed", [] { throw SolverError("window 1: s"); }, 3, "window 1: s"},
                    Thrown{"solver", [] { throw SolverError("s"); }, 3, "window 1: s"},
                    Thrown{"participant", [] { throw ParticipantError("p"); }, 4, "window 1: p"},
                    Thrown{"protocol", [] { throw ProtocolError("w"); }, 5, "window 1: w"},
                    Thrown{"standard", [] { throw std::runtime_error("singular"); }, 3, "window 1: singular"},
                    Thrown{"memory", [] { throw std::bad_alloc(); }, 7, "out of memory"},
                    Thrown{"disk", [] { throw std::system_error(ENOSPC, std::generic_category(), "fields"); }, 7,
                           "No space left"},
                    Thrown{"a_number", [] { throw 7; }, 3, "not a std::exception"}),
    [](const auto& param_info) { return param_info.param.name; });

TEST_F(Serve, NamesTheFieldThatIsNotFinite) {
  spring_.on_advance = [](std::int64_t window, LinkOutput& output) {
    if (window == 3) output.value[0] = std::nan("");
  };
  start();
  peer_.coupler.ask(peer_.coupler.advance(0.0));
  peer_.coupler.ask(peer_.coupler.advance(0.0));
  peer_.say(peer_.coupler.advance(0.0));
  const auto message = failure();
  EXPECT_EQ(message.as<wire::Failure>().error_code, 3);
  EXPECT_EQ(message.as<wire::Failure>().error_culprit, "spring");
  EXPECT_EQ(message.as<wire::Failure>().error_text,
            "window 3: 'increment' of 'advanced' is not finite: nan at row 0, column 0");
  EXPECT_EQ(end(), 3);
}

TEST_F(Serve, RefusesAnotherVersion) {
  launch();
  peer_.hear();
  auto welcome = peer_.coupler.welcome();
  welcome.version = wire::protocol_version + 1;
  peer_.say(welcome);
  const auto message = failure();
  EXPECT_EQ(message.as<wire::Failure>().error_code, 5);
  EXPECT_THAT(message.as<wire::Failure>().error_text,
              HasSubstr("the coupler speaks version 8 of the wire protocol, this program speaks version 7"));
  EXPECT_EQ(end(), 5);
}

TEST_F(Serve, RefusesAnIllegalOrder) {
  launch();
  peer_.meet();
  peer_.say(peer_.coupler.initialize());
  EXPECT_THAT(failure().as<wire::Failure>().error_text,
              HasSubstr("sent 'initialize' to participant 'spring' while 'describe' was due"));
  EXPECT_EQ(end(), 5);
}

TEST_F(Serve, WaitsForTheWelcomeAsLongAsToldAtTheStart) {
  launch(0.2);
  peer_.hear();
  EXPECT_THAT(failure().as<wire::Failure>().error_text, HasSubstr("the coupler has not answered within 0.2 s"));
  EXPECT_EQ(end(), 4);
  EXPECT_THAT(said_, testing::StartsWith("spring: error: the coupler has not answered within 0.2 s"));
}

TEST_F(Serve, WaitsAfterwardsAsLongAsTheCouplerSays) {
  peer_.coupler.timeout_s = 0.3;
  launch(10.0);
  peer_.meet();
  peer_.coupler.start();
  peer_.coupler.ask(peer_.coupler.advance(0.0));
  EXPECT_THAT(failure().as<wire::Failure>().error_text,
              HasSubstr("window 1: the coupler has not answered within 0.3 s"));
  EXPECT_EQ(end(), 4);
}

}  // namespace
}  // namespace ricochet::participant
