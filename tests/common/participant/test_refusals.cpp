// Requests that make no sense, and participants that break their word: each is refused by name.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/spring_mass.hpp"

namespace ricochet::participant {
namespace {

using testing::HasSubstr;
using wire::Kind;
using wire::Message;

template <class ErrorType = ProtocolError, class Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const ErrorType& error) {
    return error.what();
  }
  return "no error of that kind";
}

// ---- requests that make no sense

class Refusal : public testing::Test {
 protected:
  SpringMass spring_;
  InProcess run_{spring_, 1};
  std::string refused(const Message& request) {
    return error_of([&] { run_.coupler.ask(request); });
  }
};

TEST_F(Refusal, OfAnotherRun) {
  auto request = run_.coupler.request(Kind::describe);
  request.run_id = "run-2";
  EXPECT_EQ(refused(request), "the coupler sent 'describe' of run 'run-2', this is run 'run-1'");
}

TEST_F(Refusal, OfASetupWithoutMeaning) {
  run_.coupler.ask(Kind::describe);
  const auto spoiled = [&](auto spoil) {
    SpringMass spring;
    InProcess run(spring, 1);
    run.coupler.ask(Kind::describe);
    auto request = run.coupler.initialize();
    spoil(request);
    return error_of([&] { run.coupler.ask(request); });
  };
  EXPECT_THAT(spoiled([](Message& m) { m.as<wire::Initialize>().window_size_s = 0; }),
              HasSubstr("window_size_s = 0, expected > 0"));
  EXPECT_THAT(spoiled([](Message& m) { m.as<wire::Initialize>().history_every = 0; }),
              HasSubstr("history_every = 0, expected 1 to 2147483647"));
  EXPECT_THAT(spoiled([](Message& m) { m.as<wire::Initialize>().history_every = std::int64_t{1} << 62; }),
              HasSubstr("history_every = 4611686018427387904, expected 1 to 2147483647"));
  EXPECT_THAT(spoiled([](Message& m) { m.as<wire::Initialize>().fields_every = -1; }),
              HasSubstr("fields_every = -1, expected 0 to 2147483647"));
  EXPECT_THAT(spoiled([](Message& m) { m.as<wire::Initialize>().last_window = -1; }),
              HasSubstr("last_window = -1, expected >= 0"));
  EXPECT_THAT(spoiled([](Message& m) { m.as<wire::Initialize>().separation_windows = -1; }),
              HasSubstr("separation_windows = -1"));
  EXPECT_THAT(spoiled([](Message& m) { m.as<wire::Initialize>().interface_mass_kg.resize(2, 1); }),
              HasSubstr("'interface_mass_kg' with 2 x 1 numbers, the interface of participant 'spring' has 1 x 1"));
}

TEST_F(Refusal, OfAnUnknownIntegration) {
  run_.coupler.ask(Kind::describe);
  run_.coupler.ask(run_.coupler.initialize());
  auto request = run_.coupler.synchronise();
  request.as<wire::Synchronise>().integration = "runge_kutta";
  EXPECT_THAT(refused(request), HasSubstr("the integration 'runge_kutta', expected one of 'implicit_newmark'"));
}

TEST_F(Refusal, OfWindowsOutOfTurn) {
  run_.coupler.start();
  auto request = run_.coupler.advance(0.0);
  request.window = 2;
  EXPECT_THAT(refused(request), HasSubstr("asked for window 2, the next one is window 1"));
}

TEST_F(Refusal, OfWindowsAfterTheLast) {
  run_.coupler.last_window = 1;
  run_.coupler.start();
  run_.coupler.ask(run_.coupler.advance(0.0));
  EXPECT_THAT(refused(run_.coupler.advance(0.0)), HasSubstr("asked for window 2, the last one is window 1"));
}

TEST_F(Refusal, OfSeveralWindowsWithAnInterface) {
  run_.coupler.start();
  auto request = run_.coupler.advance(0.0);
  request.as<wire::Advance>().windows = 2;
  EXPECT_THAT(refused(request),
              HasSubstr("2 windows at once: that needs a participant without interface nodes (this one has 1)"));
}

TEST_F(Refusal, OfNoWindows) {
  run_.coupler.start();
  auto request = run_.coupler.advance(0.0);
  request.as<wire::Advance>().windows = 0;
  EXPECT_THAT(refused(request), HasSubstr("asked for 0 windows"));
}

TEST_F(Refusal, OfArraysOfTheWrongShape) {
  run_.coupler.start();
  auto request = run_.coupler.advance(0.0);
  request.as<wire::Advance>().link_increment.resize(1, 2);
  EXPECT_THAT(refused(request),
              HasSubstr("'link_increment' with 1 x 2 numbers, the interface of participant 'spring' has 1 x 1"));
}

TEST_F(Refusal, OfAbsoluteValuesOfTheWrongShape) {
  run_.coupler.start();
  auto request = run_.coupler.advance(0.0);
  request.as<wire::Advance>().link_absolute.resize(3, 1);
  EXPECT_THAT(refused(request), HasSubstr("'link_absolute' with 3 x 1"));
}

TEST_F(Refusal, OfAcceptingAnotherWindow) {
  run_.coupler.start();
  run_.coupler.ask(run_.coupler.advance(0.0, false));
  run_.coupler.window = 3;
  EXPECT_THAT(refused(run_.coupler.request(Kind::accept)), HasSubstr("accepted window 3, the trial was of window 1"));
}

TEST_F(Refusal, OfWhatIsNotItsTurn) {
  EXPECT_EQ(refused(run_.coupler.advance(0.0)),
            "the coupler sent 'advance' to participant 'spring' while 'describe' was due; "
            "expected one of 'describe', 'failure'");
}

TEST(Session, RefusesToRepeatIfItCannot) {
  SpringMass spring;
  spring.capabilities.clear();
  InProcess run(spring, 1);
  run.coupler.start();
  run.coupler.ask(run.coupler.advance(0.0, false));
  EXPECT_THAT(error_of([&] { run.coupler.ask(run.coupler.advance(0.0)); }),
              HasSubstr("asked to repeat window 1, but participant 'spring' lacks the capability 'repeat_window'"));
}

TEST(Session, RefusesAStrangeWelcome) {
  SpringMass spring;
  const auto refused = [&](auto spoil) {
    Session session(spring);
    Message reply;
    session.hello(reply);
    Message welcome;
    welcome.kind = Kind::welcome;
    welcome.as<wire::Welcome>().participant = "spring";
    welcome.as<wire::Welcome>().timeout_s = 1.0;
    spoil(welcome);
    return error_of([&] { session.handle(welcome, reply); });
  };
  EXPECT_THAT(refused([](Message& m) { m.as<wire::Welcome>().participant = "rod"; }),
              HasSubstr("welcomed participant 'rod', this is 'spring'"));
  EXPECT_THAT(refused([](Message& m) { m.as<wire::Welcome>().timeout_s = 0; }),
              HasSubstr("the timeout 0 s, expected more than 0"));
  EXPECT_EQ(refused([](Message&) {}), "no error of that kind");
}

// ---- participants that break their word

TEST(Session, NamesNumbersThatAreNotFinite) {
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    SpringMass spring(3);
    spring.on_advance = [&](std::int64_t window, LinkOutput& output) {
      if (window == 2) output.value[1] = wrong;
    };
    InProcess run(spring, 3);
    run.coupler.start();
    run.coupler.ask(run.coupler.advance(0.0));
    EXPECT_THAT(error_of<SolverError>([&] { run.coupler.ask(run.coupler.advance(0.0)); }),
                testing::AllOf(HasSubstr("'increment' of 'advanced' is not finite"), HasSubstr("at row 1, column 0")));
    EXPECT_EQ(run.session.window(), 2);
  }
}

TEST(Session, RefusesResultsOfTheWrongSize) {
  const auto refused = [](auto spoil) {
    SpringMass spring(2);
    spring.on_advance = [&](std::int64_t, LinkOutput& output) { spoil(output); };
    InProcess run(spring, 2);
    run.coupler.start();
    return error_of<ParticipantError>([&] { run.coupler.ask(run.coupler.advance(0.0)); });
  };
  EXPECT_EQ(refused([](LinkOutput& output) { output.value.pop_back(); }),
            "participant 'spring' (explicit) answered with 1 numbers as force, expected 2");
  EXPECT_EQ(refused([](LinkOutput& output) {
              output.velocity_m_s = {1, 2};
            }),
            "participant 'spring' (explicit) answered with 2 numbers as velocity_m_s, expected 0");
}

/// Describes itself as told, and records one number whatever it announced.
class Liar : public SpringMass {
 public:
  explicit Liar(std::function<void(Description&)> lie) : lie_(std::move(lie)) {}
  Description describe() override {
    auto d = SpringMass::describe();
    lie_(d);
    return d;
  }
  void record(std::vector<double>& row) override { row.push_back(1.0); }

 private:
  std::function<void(Description&)> lie_;
};

TEST(Session, RefusesADescriptionThatContradictsItself) {
  const auto refused = [](std::function<void(Description&)> lie) {
    Liar liar(std::move(lie));
    return error_of<ParticipantError>([&] { Session session(liar); });
  };
  EXPECT_THAT(refused([](auto& d) { d.name.clear(); }), HasSubstr("it has no name"));
  EXPECT_THAT(refused([](auto& d) { d.components = 4; }), HasSubstr("it has 4 components per node"));
  EXPECT_THAT(refused([](auto& d) { d.interface_mass_kg.clear(); }),
              HasSubstr("1 interface nodes of 1 components, but 1 coordinates and 0 masses"));
  EXPECT_THAT(refused([](auto& d) { d.interface_position_m.push_back(0); }), HasSubstr("but 2 coordinates"));
}

TEST(Session, RefusesHistoryRowsOfTheWrongLength) {
  Liar liar([](Description&) {});
  InProcess run(liar, 1);
  run.coupler.start();
  EXPECT_EQ(error_of<ParticipantError>([&] { run.session.work_ahead(); }),
            "participant 'spring' recorded 1 numbers, it announced 2 columns");
}

void expect_refused(InProcess& run, const Message& request, const std::string& text) {
  try {
    run.coupler.ask(request);
    FAIL() << text;
  } catch (const ProtocolError& error) {
    EXPECT_THAT(error.what(), HasSubstr(text));
  }
}

TEST(Refusals, OfAnotherDriveThanItIsMadeFor) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.ask(Kind::describe);
  run.coupler.driven_by = "force";
  expect_refused(run, run.coupler.initialize(),
                 "drives explicit participant 'spring' by force, which it is not made for");
  InProcess again(spring, 1);
  again.coupler.ask(Kind::describe);
  again.coupler.driven_by = "torque";
  expect_refused(again, again.coupler.initialize(), "drives by 'torque', expected one of 'displacement', 'force'");
}

TEST(Refusals, OfAnInterfaceStiffnessItDoesNotKnowOrOfAWrongSize) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.ask(Kind::describe);
  auto request = run.coupler.initialize();
  request.as<wire::Initialize>().interface_stiffness.resize(1, 1);
  expect_refused(run, request, "lacks the capability 'interface_stiffness'");
  InProcess again(spring, 1);
  again.coupler.ask(Kind::describe);
  request = again.coupler.initialize();
  request.as<wire::Initialize>().interface_stiffness.resize(2, 2);
  expect_refused(again, request, "'interface_stiffness' with 2 x 2 numbers");
}

/// Can do single substeps, where it is driven by force.
struct SubsteppingSpring : SpringMass {
  Description describe() override {
    auto d = SpringMass::describe();
    d.capabilities.insert(d.capabilities.end(), {Capability::driven_by_force, Capability::single_substep});
    return d;
  }
};

TEST(Refusals, OfSubsteps) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.ask(Kind::describe);
  auto request = run.coupler.initialize();
  request.as<wire::Initialize>().substeps = 0;
  expect_refused(run, request, "substeps = 0, expected 1 to 2147483647");
  InProcess again(spring, 1);
  again.coupler.start();
  request = again.coupler.advance(0.0);
  request.substep = 1;
  expect_refused(again, request, "lacks the capability 'single_substep'");
  SubsteppingSpring able;
  InProcess by_displacement(able, 1);
  by_displacement.coupler.start();
  request = by_displacement.coupler.advance(0.0);
  request.substep = 1;
  expect_refused(by_displacement, request, "asked for substep 1, but drives participant 'spring' by displacement");
}

TEST(Refusals, OfSavingAStateThatCannotBeSaved) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.start();
  expect_refused(run, run.coupler.request(Kind::save_state), "lacks the capability 'save_state'");
  InProcess again(spring, 1);
  again.coupler.start();
  expect_refused(again, again.coupler.request(Kind::restore_state), "lacks the capability 'save_state'");
  spring.capabilities.push_back(Capability::save_state);
  InProcess promised(spring, 1);
  promised.coupler.start();
  EXPECT_THAT(error_of<ParticipantError>([&] { promised.coupler.ask(Kind::save_state); }),
              HasSubstr("announces the capability 'save_state' but cannot save its state"));
}

/// Windows of another size, as often as they come.
TEST(Refusals, OfWindowsOfAnotherSize) {
  const auto reconfigure = [](InProcess& run, double size_s) {
    auto request = run.coupler.request(Kind::reconfigure);
    request.as<wire::Reconfigure>().window_size_s = size_s;
    return request;
  };
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.start();
  expect_refused(run, reconfigure(run, 0.02), "windows of another size, but participant 'spring' lacks the capability");
  spring.capabilities.push_back(Capability::reconfigure);
  InProcess promised(spring, 1);
  promised.coupler.start();
  EXPECT_THAT(error_of<ParticipantError>([&] { promised.coupler.ask(reconfigure(promised, 0.02)); }),
              HasSubstr("announces the capability 'reconfigure', but does not implement it"));
  InProcess stopped(spring, 1);
  stopped.coupler.start();
  expect_refused(stopped, reconfigure(stopped, 0.0), "window_size_s = 0, expected > 0");
}

/// Keeps nothing of its own.
struct KeptSpring : SpringMass {
  Description describe() override {
    auto d = SpringMass::describe();
    d.capabilities.push_back(Capability::save_state);
    return d;
  }
  std::string save_state() override { return ""; }
  void restore_state(std::string_view) override {}
};

/// The state that a session of one node would have kept.
std::string kept(std::int64_t window, std::vector<double> link, std::vector<double> rows,
                 std::vector<double> stress_rows, std::vector<double> force_rows = {}, std::int64_t contacts = -1,
                 double size_s = 0.01) {
  Archive out;
  ContactStatus contact;
  std::string own;
  std::vector<double> probe_rows;
  double drift = 0.0;
  WindowClock clock = size_s;
  out(window, window, link, link, drift, contact, rows, stress_rows, probe_rows, force_rows, contacts, clock, own);
  return out.take();
}

TEST(Refusals, OfStatesThatCannotBe) {
  const auto refused = [](const std::string& bytes) {
    KeptSpring spring;
    InProcess run(spring, 1);
    run.coupler.last_window = 50;
    run.coupler.start();
    auto request = run.coupler.request(wire::Kind::restore_state);
    request.as<wire::RestoreState>().saved.data = bytes;
    return error_of<ConfigError>([&] { run.coupler.ask(request); });
  };
  const std::string of_another_run = "the state of participant 'spring': it is of another run";
  EXPECT_EQ(refused(kept(50, {0.0}, {50.0, 1.0, 2.0}, {})), "no error of that kind");
  EXPECT_EQ(refused(kept(51, {0.0}, {}, {})), of_another_run) << "beyond the last window";
  EXPECT_EQ(refused(kept(-1, {0.0}, {}, {})), of_another_run);
  EXPECT_EQ(refused(kept(2, {0.0}, {2.0, 1.0}, {})), of_another_run) << "a part of a row";
  EXPECT_EQ(refused(kept(2, {0.0}, {}, {2.0})), of_another_run) << "rows of a table without columns";
  EXPECT_EQ(refused(kept(2, {0.0}, {}, {}, {2.0}, 1)), of_another_run) << "a contact without its force";
  EXPECT_EQ(refused(kept(2, {0.0}, {}, {}, {}, -2)), of_another_run);
  EXPECT_THAT(refused(kept(2, {0.0}, {}, {}, {}, -1, 0.02)), HasSubstr("it is of windows whose size changed"));
  EXPECT_THAT(refused(kept(2, {0.0, 1.0}, {}, {})), HasSubstr("it is of another scene: a list of 2, expected 1"));
}

}  // namespace
}  // namespace ricochet::participant
