// load_state and read_state: what `ricochet stability` asks of a session.
#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/spring_mass.hpp"

namespace ricochet::participant {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using wire::Kind;
using wire::Message;

SpringMass capable() {
  SpringMass spring;
  spring.capabilities = {Capability::load_state};
  return spring;
}

class LoadState : public testing::Test {
 protected:
  SpringMass spring_ = capable();
  InProcess run_{spring_, 1};

  Message load(std::vector<double> state, const std::string& frozen_contact = "open") {
    auto request = run_.coupler.request(Kind::load_state);
    request.as<wire::LoadState>().state = {static_cast<int>(state.size()), 1, std::move(state)};
    request.as<wire::LoadState>().frozen_contact = frozen_contact;
    return request;
  }
  template <class ErrorType>
  std::string refused(const Message& request) {
    try {
      run_.coupler.ask(request);
    } catch (const ErrorType& error) {
      return error.what();
    }
    return "not refused";
  }
};

TEST_F(LoadState, TakesTheMotionAndGoesOnFromIt) {
  run_.coupler.start();
  EXPECT_EQ(run_.coupler.ask(load({1e-3, 0.5}, "sticking")).kind, Kind::state_loaded);
  EXPECT_EQ(spring_.frozen, FrozenContact::sticking);
  run_.coupler.ask(run_.coupler.synchronise(2e-3));
  run_.coupler.ask(run_.coupler.advance(0.0));
  const auto& reply = run_.coupler.ask(Kind::read_state);
  EXPECT_EQ(reply.kind, Kind::state);
  // One central difference step of 0.01 s from there: a = 100 (2e-3 - 1e-3) = 0.1.
  const double u = 1e-3 + 0.01 * 0.5 + 0.5e-4 * 0.1;
  EXPECT_DOUBLE_EQ(reply.as<wire::State>().state.data[0], u);
  EXPECT_DOUBLE_EQ(reply.as<wire::State>().state.data[1], 0.5 + 0.005 * (0.1 + 100.0 * (2e-3 - u)));
  EXPECT_THAT(reply.as<wire::State>().state_scale.data, ElementsAre(100.0, 1.0));
  EXPECT_EQ(reply.as<wire::State>().state.columns, 1);
}

TEST_F(LoadState, WantsASynchronisationNext) {
  run_.coupler.start();
  run_.coupler.ask(load({0.0, 0.0}));
  EXPECT_THAT(refused<ProtocolError>(run_.coupler.advance(0.0)), HasSubstr("while 'synchronise' was due"));
}

TEST_F(LoadState, IsForTheEndOfAnAcceptedWindow) {
  run_.coupler.ask(Kind::describe);
  run_.coupler.ask(run_.coupler.initialize());
  EXPECT_THAT(refused<ProtocolError>(load({0.0, 0.0})), HasSubstr("sent 'load_state'"));
}

TEST_F(LoadState, RefusesAStateOfAnotherSize) {
  run_.coupler.start();
  EXPECT_EQ(refused<ProtocolError>(load({0.0})),
            "the coupler sent 'state' with 1 x 1 numbers, that of participant 'spring' has 2 x 1");
}

TEST_F(LoadState, RefusesAnUnknownFrozenContact) {
  run_.coupler.start();
  EXPECT_THAT(refused<ProtocolError>(load({0.0, 0.0}, "slipping")),
              HasSubstr("frozen contact 'slipping', expected one of 'open', 'sticking'"));
}

TEST_F(LoadState, NeedsAScalePerNumber) {
  run_.coupler.start();
  spring_.missing_scales = 1;
  EXPECT_EQ(refused<ParticipantError>(run_.coupler.request(Kind::read_state)),
            "participant 'spring' told a state of 2 numbers with 1 scales, expected as many, each > 0");
}

TEST_F(LoadState, IsRefusedWithoutTheCapability) {
  SpringMass spring;
  for (const Kind kind : {Kind::load_state, Kind::read_state}) {
    InProcess run(spring, 1);
    run.coupler.start();
    auto request = run.coupler.request(kind);
    if (kind == Kind::load_state) {
      request.as<wire::LoadState>().state = {2, 1, {0.0, 0.0}};
      request.as<wire::LoadState>().frozen_contact = "open";
    }
    try {
      run.coupler.ask(request);
      ADD_FAILURE() << wire::name(kind);
    } catch (const ProtocolError& error) {
      EXPECT_THAT(error.what(), HasSubstr("participant 'spring' lacks the capability 'load_state'"));
    }
  }
}

TEST(ParticipantDefaults, SayThatTheyCannotLoadAState) {
  class Empty : public SpringMass {
   public:
    void load_state(const std::vector<double>& s, FrozenContact c) override { Participant::load_state(s, c); }
    void read_state(std::vector<double>& s, std::vector<double>& c) override { Participant::read_state(s, c); }
  } empty;
  std::vector<double> state, scale;
  EXPECT_THROW(empty.load_state({}, FrozenContact::open), ParticipantError);
  EXPECT_THROW(empty.read_state(state, scale), ParticipantError);
}

}  // namespace
}  // namespace ricochet::participant
