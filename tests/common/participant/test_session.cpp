#include <gmock/gmock.h>

#include <cmath>

#include "common/base/error.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/spring_mass.hpp"

namespace ricochet::participant {
namespace {

using testing::ElementsAre;
using wire::Kind;
using wire::Message;

TEST(Session, DescribesTheParticipant) {
  SpringMass spring(2);
  Session session(spring);
  Message message;
  session.hello(message);
  EXPECT_EQ(message.kind, Kind::hello);
  EXPECT_EQ(message.as<wire::Hello>().participant, "spring");
  EXPECT_EQ(message.as<wire::Hello>().role, "explicit");
  EXPECT_EQ(message.as<wire::Hello>().solver, "spring_mass");
  EXPECT_GT(message.as<wire::Hello>().process_id, 0);
  InProcess run(spring, 2);
  message = run.coupler.ask(Kind::describe);
  EXPECT_EQ(message.kind, Kind::description);
  EXPECT_EQ(message.run_id, "run-1");
  EXPECT_EQ(message.as<wire::Description>().components, 1);
  EXPECT_THAT(message.as<wire::Description>().bodies, ElementsAre("rod"));
  EXPECT_THAT(message.as<wire::Description>().interface_body.data, ElementsAre(0, 0));
  EXPECT_THAT(message.as<wire::Description>().interface_position_m.data, ElementsAre(0.0, 0.1));
  EXPECT_THAT(message.as<wire::Description>().interface_mass_kg.data, ElementsAre(0.5, 0.5));
  EXPECT_THAT(message.as<wire::Description>().record_columns, ElementsAre("window", "displacement_m", "velocity_m_s"));
  EXPECT_THAT(message.as<wire::Description>().capabilities, ElementsAre("repeat_window"));
}

TEST(Session, HandsTheSetupOver) {
  SpringMass spring(2);
  InProcess run(spring, 2);
  run.coupler.ask(Kind::describe);
  auto request = run.coupler.initialize();
  request.as<wire::Initialize>().until_separated_plus_s = 0.5;
  request.as<wire::Initialize>().separation_windows = 7;
  const auto& reply = run.coupler.ask(request);
  EXPECT_EQ(reply.kind, Kind::initialized);
  EXPECT_THAT(reply.as<wire::Initialized>().absolute.data, ElementsAre(0, 0));
  EXPECT_EQ(spring.setup.run_id, "run-1");
  EXPECT_EQ(spring.setup.protocol, "hughes_liu");
  EXPECT_EQ(spring.setup.output_directory, "/results");
  EXPECT_EQ(spring.setup.clock.size_s(), 0.01);
  EXPECT_THAT(spring.setup.interface_mass_kg, ElementsAre(2.5, 2.5));
  EXPECT_EQ(spring.setup.until_separated_plus_s, 0.5);
  EXPECT_EQ(spring.setup.separation_windows, 7);
  EXPECT_EQ(spring.setup.last_window, 1000);
}

TEST(Session, TellsTheAxialStressOfTheWindowsThatAreAskedFor) {
  for (const bool tells : {true, false}) {
    SpringMass spring(0);
    if (tells) spring.axial_stress_columns = {"rod/0/1/1"};
    InProcess run(spring, 0);
    const auto& description = run.coupler.ask(Kind::describe);
    EXPECT_THAT(description.as<wire::Description>().axial_stress_columns, testing::SizeIs(tells ? 2 : 0));
    auto request = run.coupler.initialize();
    request.as<wire::Initialize>().axial_stress_every = 4;
    run.coupler.ask(request);
    run.coupler.ask(run.coupler.synchronise());
    for (int n = 1; n <= 9; ++n) {
      auto window = run.coupler.advance(0.0);
      window.as<wire::Advance>().records_requested = n == 9;
      const auto& reply = run.coupler.ask(window);
      EXPECT_EQ(reply.as<wire::Advanced>().axial_stress.rows, tells && n == 9 ? 3 : 0);
      if (reply.as<wire::Advanced>().axial_stress.rows == 0) continue;
      for (int row = 0; row < 3; ++row) {
        const auto& values = reply.as<wire::Advanced>().axial_stress.data;
        EXPECT_EQ(values[static_cast<std::size_t>(2 * row)], 4 * row);
        EXPECT_EQ(values[static_cast<std::size_t>(2 * row + 1)],
                  1e9 * reply.as<wire::Advanced>().records.data[static_cast<std::size_t>(3 * 4 * row + 1)]);
      }
    }
  }
}

TEST(Session, RunsManyWindowsAtOnceWithoutInterface) {
  SpringMass spring(0);
  InProcess run(spring, 0);
  run.coupler.last_window = 314;
  run.coupler.history_every = 10;
  run.coupler.start();
  auto request = run.coupler.advance(0.0);
  request.as<wire::Advance>().windows = 300;
  request.as<wire::Advance>().records_requested = true;
  auto reply = run.coupler.ask(request);
  EXPECT_EQ(reply.window, 300);
  ASSERT_EQ(reply.as<wire::Advanced>().records.rows, 31) << "with that of the start";
  // Period 2 pi sqrt(m/k) = 0.628 s: after 300 steps of 0.01 s nearly five of them.
  EXPECT_NEAR(reply.as<wire::Advanced>().records.data[30 * 3 + 1], 1e-3 * std::cos(10.0 * 3.0), 2e-5);
  EXPECT_EQ(reply.as<wire::Advanced>().records.data[30 * 3], 300);
  run.coupler.window = 300;
  request = run.coupler.advance(0.0);
  request.as<wire::Advance>().windows = 4000;
  EXPECT_EQ(run.coupler.ask(request).window, 314) << "the last window";
}

TEST(Session, StopsWithinAChunkWhenTheContactOwnerHasFinished) {
  SpringMass spring(0);
  spring.on_advance = [&](std::int64_t window, LinkOutput&) {
    spring.status.pairs_closed = 3;
    spring.status.separation_time_s = 0.17;
    spring.status.separated = spring.status.finished = window == 25;
  };
  InProcess run(spring, 0);
  run.coupler.start();
  auto request = run.coupler.advance(0.0);
  request.as<wire::Advance>().windows = 100;
  const auto& reply = run.coupler.ask(request);
  EXPECT_EQ(reply.window, 25);
  EXPECT_TRUE(reply.as<wire::Advanced>().finished_early);
  EXPECT_TRUE(reply.as<wire::Advanced>().separated);
  EXPECT_EQ(reply.as<wire::Advanced>().pairs_closed, 3);
  EXPECT_EQ(reply.as<wire::Advanced>().separation_time_s, 0.17);
}

TEST(Session, SendsEveryHistoryRowOnce) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.history_every = 2;
  run.coupler.ask(Kind::describe);
  run.coupler.ask(run.coupler.initialize());
  std::vector<double> windows;
  const auto take = [&](const wire::Records& told) {
    for (int row = 0; row < told.records.rows; ++row)
      windows.push_back(told.records.data[3 * static_cast<std::size_t>(row)]);
    return told.records.rows;
  };
  run.coupler.ask(run.coupler.synchronise());
  run.coupler.ask(run.coupler.synchronise());  // the start may be synchronised again
  for (int n = 1; n <= 11; ++n) {
    auto request = run.coupler.advance(1e-5);
    request.as<wire::Advance>().records_requested = n == 5;
    EXPECT_EQ(take(run.coupler.ask(request).as<wire::Advanced>()), n == 5 ? 3 : 0);
    if (n == 7) run.coupler.ask(run.coupler.synchronise());
  }
  take(run.coupler.ask(Kind::finish).as<wire::Finished>());
  EXPECT_THAT(windows, ElementsAre(0, 2, 4, 6, 8, 10));
}

std::vector<std::int64_t> fields_of_run(std::int64_t every, std::int64_t last, std::int64_t end) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.fields_every = every;
  run.coupler.last_window = last;
  run.coupler.start();
  while (run.coupler.window < end) run.coupler.ask(run.coupler.advance(0.0));
  run.coupler.ask(Kind::finish);
  return spring.fields;
}

TEST(Session, WritesFieldsAtTheStartEverySoManyWindowsAndAtTheEnd) {
  EXPECT_THAT(fields_of_run(4, 10, 10), ElementsAre(0, 4, 8, 10));
  EXPECT_THAT(fields_of_run(4, 10, 6), ElementsAre(0, 4, 6)) << "ended early";
  EXPECT_THAT(fields_of_run(5, 10, 10), ElementsAre(0, 5, 10));
  EXPECT_THAT(fields_of_run(0, 10, 10), ElementsAre());
}

/// The others wait for the answer; and what was recorded of a start that is made once more does not count.
TEST(Session, RecordsTheStartAfterItsAnswerAndOnce) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.fields_every = 4;
  run.coupler.start();
  EXPECT_THAT(spring.fields, ElementsAre()) << "before the answer";
  run.session.work_ahead();
  EXPECT_THAT(spring.fields, ElementsAre(0));
  run.coupler.ask(run.coupler.synchronise(0.002));
  run.session.work_ahead();
  EXPECT_THAT(spring.fields, ElementsAre(0, 0)) << "the files are written anew";
  auto window = run.coupler.advance(0.0);
  window.as<wire::Advance>().records_requested = true;
  EXPECT_EQ(run.coupler.ask(window).as<wire::Advanced>().records.rows, 2);
}

TEST(Session, TellsTimesAndSpans) {
  SpringMass spring(0);
  InProcess run(spring, 0);
  run.coupler.last_window = 10'000;
  run.coupler.start();
  for (std::size_t n = 0; n < Session::max_spans + 50; ++n) run.coupler.ask(run.coupler.advance(0.0));
  run.session.add_wait(1.5);
  run.session.add_wait(2.0);
  const auto& reply = run.coupler.ask(Kind::finish);
  EXPECT_TRUE(run.session.over());
  EXPECT_EQ(reply.as<wire::Finished>().wait_s, 3.5);
  ASSERT_EQ(reply.as<wire::Finished>().spans_s.rows, static_cast<int>(Session::max_spans));
  double sum = 0.0, last_end = 0.0;
  for (int i = 0; i < reply.as<wire::Finished>().spans_s.rows; ++i) {
    const double* span = &reply.as<wire::Finished>().spans_s.data[3 * static_cast<std::size_t>(i)];
    EXPECT_GE(span[1], last_end);
    EXPECT_GE(span[2], span[1]);
    last_end = span[2];
    sum += span[2] - span[1];
  }
  EXPECT_EQ(reply.as<wire::Finished>().spans_s.data[0], 0) << "the first is about the start";
  EXPECT_EQ(reply.as<wire::Finished>().spans_s.data[3 * 100], 98)
      << "describe, initialize, synchronise, then one window each";
  EXPECT_GE(reply.as<wire::Finished>().compute_s, 0.99 * sum);
}

/// Moves freely under the link force; keeps what it was asked for.
class DrivenByForce : public SpringMass {
 public:
  DrivenByForce() : SpringMass(1) {}
  Description describe() override {
    auto d = SpringMass::describe();
    d.capabilities = {Capability::repeat_window, Capability::driven_by_force, Capability::single_substep};
    return d;
  }
  void initialize(const Setup& given, LinkOutput& output) override {
    SpringMass::initialize(given, output);
    output = {{0.0}, {}, {}};
  }
  void synchronise(Integration, const std::vector<double>&, LinkOutput& output) override {
    output = {{0.0}, {0.0}, {0.0}};
  }
  void advance(std::int64_t, const std::vector<double>& input, LinkOutput& output) override {
    asked.push_back(0);
    output = {{input[0]}, {2 * input[0]}, {3 * input[0]}};
  }
  void advance_substep(std::int64_t, int substep, const std::vector<double>& input, LinkOutput& output) override {
    asked.push_back(substep);
    output = {{input[0]}, {2 * input[0]}, {3 * input[0]}};
  }
  void accept() override {}
  std::vector<int> asked;
};

TEST(Session, DrivesAnExplicitParticipantByForceInSubsteps) {
  DrivenByForce mass;
  InProcess run(mass, 1);
  run.coupler.driven_by = "force";
  run.coupler.ask(Kind::describe);
  auto initialize = run.coupler.initialize();
  initialize.as<wire::Initialize>().substeps = 3;
  run.coupler.ask(initialize);
  EXPECT_EQ(mass.setup.driven_by, Drive::force);
  EXPECT_EQ(mass.setup.substeps, 3);
  const auto synchronised = run.coupler.ask(run.coupler.synchronise());
  EXPECT_EQ(synchronised.as<wire::Synchronised>().velocity_m_s.rows, 1);
  for (int substep = 1; substep <= 3; ++substep) {
    auto request = run.coupler.advance(0.5, false);
    request.substep = substep;
    EXPECT_THAT(run.coupler.ask(request).as<wire::Advanced>().velocity_m_s.data, ElementsAre(substep));
    request = run.coupler.advance(0.5, true);
    request.substep = substep;
    const auto reply = run.coupler.ask(request);
    EXPECT_EQ(reply.substep, substep);
    if (substep < 3) --run.coupler.window;
  }
  EXPECT_EQ(run.coupler.ask(run.coupler.advance(0.0)).window, 2) << "the last substep ended window 1";
  EXPECT_THAT(mass.asked, ElementsAre(1, 1, 2, 2, 3, 3, 0));
}

TEST(Session, ASynchronisationDropsTheTrial) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.start();
  run.coupler.ask(run.coupler.advance(1e-5, false));
  EXPECT_EQ(run.coupler.ask(run.coupler.synchronise()).kind, Kind::synchronised);
  EXPECT_EQ(run.coupler.ask(run.coupler.advance(1e-5)).window, 1);
}

}  // namespace
}  // namespace ricochet::participant
