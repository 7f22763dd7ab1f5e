#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "coupler/run/time_loop.hpp"
#include "tests/coupler/protocols/spring_chain.hpp"

namespace ricochet::coupler::test {
namespace {

using testing::Contains;
using testing::ElementsAre;

struct Setting {
  FakeParticipant explicit_side{"explicit", false, Chain::of({1.0}, {1.0}, 0.0), {1}, Eigen::VectorXd::Zero(2)};
  FakeParticipant implicit_side{"implicit", true, Chain::of({1.0}, {1.0}, 1.0), {0}, Eigen::VectorXd::Zero(2)};
  std::unique_ptr<Coupling> coupling = couple({&explicit_side, &implicit_side}, 0.1);
  std::unique_ptr<Protocol> protocol = make_protocol("hughes_liu", {});
};

TEST(TimeLoop, RunsToTheLastWindowAndBringsRecords) {
  Setting s;
  std::vector<std::int64_t> brought;
  TimeLoop loop(*s.coupling, *s.protocol, {100, 10, true, false}, [&](std::int64_t window) {
    brought.push_back(window);
    for (auto& link : s.coupling->links()) (void)link.take_records();
  });
  loop.run();
  EXPECT_EQ(loop.window(), 100);
  EXPECT_EQ(brought.front(), 0);
  EXPECT_EQ(brought.back(), 100);
  EXPECT_GE(brought.size(), 4U);
}

/// hughes_liu, with the windows at whose ends absolute values are asked for.
class Recorder final : public Protocol {
 public:
  void step(Coupling& coupling, const Step& step) override {
    if (step.absolute) absolute_at.push_back(step.accepted_window + step.windows);
    inner_->step(coupling, step);
  }
  std::vector<std::int64_t> absolute_at;

 private:
  std::unique_ptr<Protocol> inner_ = make_protocol("hughes_liu", {});
};

TEST(TimeLoop, ExchangesAbsoluteValuesEverySoManyWindows) {
  Setting s;
  Recorder recorder;
  TimeLoop loop(*s.coupling, recorder, {25, 10, true, false}, [](std::int64_t) {});
  loop.run();
  EXPECT_THAT(recorder.absolute_at, ElementsAre(10, 20));
}

TEST(TimeLoop, EndsEarlyWhenTheContactIsOver) {
  Setting s;
  s.implicit_side.finish_at = 17;
  TimeLoop loop(*s.coupling, *s.protocol, {100, 0, true, false}, [](std::int64_t) {});
  loop.run();
  EXPECT_EQ(loop.window(), 17);
}

TEST(TimeLoop, BaselineIsAskedForManyWindowsAtOnce) {
  FakeParticipant alone("implicit", true, Chain::of({1.0}, {1.0}, 0.0), {}, Eigen::VectorXd::Zero(2));
  auto coupling = couple({&alone}, 0.1);
  const auto protocol = make_protocol("all_implicit", {});
  TimeLoop loop(*coupling, *protocol, {1000, 10, false, false}, [](std::int64_t) {});
  alone.asked.clear();
  loop.run();
  EXPECT_EQ(loop.window(), 1000);
  EXPECT_LT(alone.asked.size(), 20U);
}

TEST(TimeLoop, ABaselineWhoseBodiesCouldMeetIsAskedForFew) {
  FakeParticipant alone("implicit", true, Chain::of({1.0}, {1.0}, 0.0), {}, Eigen::VectorXd::Zero(2));
  auto coupling = couple({&alone}, 0.1);
  const auto protocol = make_protocol("all_implicit", {});
  std::vector<std::int64_t> brought;
  TimeLoop loop(*coupling, *protocol, {1000, 10, false, false, true},
                [&](std::int64_t window) { brought.push_back(window); });
  loop.run();
  ASSERT_GT(brought.size(), 2U);
  for (std::size_t i = 1; i < brought.size(); ++i) EXPECT_LE(brought[i] - brought[i - 1], 32);
}

/// Everything that a participant tells of departures and outlines is checked before it is believed.
TEST(Departures, WrongOnesAreRefusedByName) {
  const auto refusal = [](const wire::Array& departures, const wire::Array& outline) -> std::string {
    Setting s;
    s.implicit_side.departures = departures;
    s.implicit_side.outline = outline;
    TimeLoop loop(*s.coupling, *s.protocol, {40, 0, true, false}, [](std::int64_t) {});
    try {
      loop.run();
    } catch (const ProtocolError& error) {
      return error.what();
    }
    return "";
  };
  const auto row = [](double kind, double body) {
    return wire::Array{1, 14, {kind, body, 16, 32, 1, 0.03, 32, 0, 0, 0, 0.03, 0, 0, 0}};
  };
  EXPECT_EQ(refusal(row(1, 0), {1, 3, {0, 0, 1e-3}}), "");
  EXPECT_THAT(refusal(row(9, 0), {}),
              testing::HasSubstr("participant 'implicit' sent the unknown kind 9 in 'departures'"));
  EXPECT_THAT(refusal(row(0.5, 0), {}), testing::HasSubstr("unknown kind 0.5"));
  EXPECT_THAT(refusal(row(1, 9), {}), testing::HasSubstr("named body 9 in 'departures'"));
  EXPECT_THAT(refusal({1, 2, {1, 0}}, {}), testing::HasSubstr("sent 'departures' with rows of 2 numbers, expected 14"));
  EXPECT_THAT(refusal({}, {1, 2, {0, 0}}), testing::HasSubstr("sent 'outline' with rows of 2 numbers, expected 3"));
  EXPECT_THAT(refusal({}, {1, 3, {-1, 0, 0}}), testing::HasSubstr("named body -1 in 'outline'"));
}

TEST(TimeLoop, SwitchesAwayAfterSeparationAndBackBeforeContact) {
  Setting s;
  auto& status = s.implicit_side.status;
  status.separated = true;
  status.gap_min_m = 1.0;
  std::vector<bool> all_explicit;
  TimeLoop loop(*s.coupling, *s.protocol, {200, 0, true, true}, [&](std::int64_t window) {
    if (window == 0) return;
    all_explicit.push_back(s.coupling->all_explicit());
    status.gap_rate_min_m_s = -1.0;  // closes 0.1 m a window
    status.gap_min_m = window < 100 ? 0.21 : 0.19;
  });
  loop.run();
  EXPECT_TRUE(all_explicit.front());
  EXPECT_FALSE(all_explicit.back());
  ASSERT_EQ(loop.switches().size(), 2U);
  EXPECT_EQ(loop.switches()[0].to, Role::explicit_solver);
  EXPECT_EQ(loop.switches()[1].to, Role::implicit_solver);
  EXPECT_THAT(s.implicit_side.asked, Contains("synchronise").Times(3));
}

wire::ContactReport report(bool separated, double gap, double rate, int closed = 0) {
  return {closed, gap, rate, separated, 0.0, false};
}

TEST(SeparationSwitch, WaitsForSeparationAndForRoom) {
  SeparationSwitch s;
  EXPECT_FALSE(s.update(report(false, 1.0, -10.0), 0.1));
  EXPECT_FALSE(s.update(report(true, 3.9, 1.0), 0.1));  // four windows of the fastest closing are 4 m
  EXPECT_TRUE(s.update(report(true, 4.1, 1.0), 0.1));
}

TEST(SeparationSwitch, GoesBackWhileAWholeWindowStillFits) {
  SeparationSwitch s;
  EXPECT_TRUE(s.update(report(true, 5.0, -10.0), 0.1));
  EXPECT_TRUE(s.update(report(true, 2.1, -1.0), 0.1));
  EXPECT_FALSE(s.update(report(true, 1.9, -1.0), 0.1));
  EXPECT_FALSE(s.update(report(true, 3.0, 1.0), 0.1));  // hysteresis
}

TEST(SeparationSwitch, AClosedPairAlwaysEndsIt) {
  SeparationSwitch s;
  EXPECT_TRUE(s.update(report(true, 5.0, 1.0), 0.1));
  EXPECT_FALSE(s.update(report(true, 5.0, 1.0, 1), 0.1));
}

}  // namespace
}  // namespace ricochet::coupler::test
