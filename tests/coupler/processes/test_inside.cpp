#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "coupler/processes/inside.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/spring_mass.hpp"

namespace ricochet::coupler {
namespace {

using participant::SpringMass;
using wire::Kind;

/// Asks who is inside; an answer that does not come is the one before.
class Asked {
 public:
  explicit Asked(std::function<void(SpringMass&)> prepare = nullptr)
      : coupler([this](const wire::Message& request) -> const wire::Message& { return ask(request); }, 1) {
    auto spring = std::make_unique<SpringMass>(1);
    if (prepare) prepare(*spring);
    inside_ = std::make_unique<Inside>(std::move(spring));
    coupler.ask(coupler.welcome());
    EXPECT_FALSE(answered);
    coupler.ask(Kind::describe);
    coupler.ask(coupler.initialize());
    coupler.ask(coupler.synchronise());
  }
  const wire::Message& ask(wire::Message request) {
    request.version = wire::protocol_version;
    inside_->take(request);
    answered = inside_->work(answer_);
    return answer_;
  }
  bool work() { return inside_->work(answer_); }

  participant::ScriptedCoupler coupler;
  bool answered = false;

 private:
  std::unique_ptr<Inside> inside_;
  wire::Message answer_;
};

TEST(Inside, AnswersOnceAndHasNothingToDoThen) {
  Asked asked;
  EXPECT_EQ(asked.coupler.ask(asked.coupler.advance(0.001)).kind, Kind::advanced);
  EXPECT_TRUE(asked.answered);
  EXPECT_FALSE(asked.work()) << "what the answer did not wait for is done, but says nothing";
  EXPECT_FALSE(asked.work());
  EXPECT_EQ(asked.coupler.ask(Kind::finish).kind, Kind::finished);
}

TEST(Inside, WhatGoesWrongIsAnAnswer) {
  Asked asked([](SpringMass& spring) {
    spring.on_advance = [](std::int64_t window, participant::LinkOutput&) {
      if (window == 2) throw SolverError("the spring broke");
    };
  });
  EXPECT_EQ(asked.coupler.ask(asked.coupler.advance(0.001)).kind, Kind::advanced);
  const auto& failed = asked.coupler.ask(asked.coupler.advance(0.001));
  ASSERT_EQ(failed.kind, Kind::failure);
  EXPECT_EQ(failed.as<wire::Failure>().error_text, "window 2: the spring broke");
  EXPECT_EQ(failed.as<wire::Failure>().error_code, static_cast<int>(ExitCode::unstable));
}

TEST(Inside, RefusesAParticipantThatContradictsItself) {
  struct Nameless : SpringMass {
    participant::Description describe() override { return {}; }
  };
  EXPECT_THROW(Inside(std::make_unique<Nameless>()), Error);
}

}  // namespace
}  // namespace ricochet::coupler
