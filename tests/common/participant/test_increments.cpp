// Increments travel: they add up to the absolute values, repeat bit by bit, and a resynchronisation replaces
// them.
#include <gmock/gmock.h>

#include <cmath>

#include "common/base/error.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/spring_mass.hpp"

namespace ricochet::participant {
namespace {

using wire::Kind;

/// Some motion of the interface node [m].
double motion(std::int64_t window) {
  return 1e-3 * std::sin(0.3 * static_cast<double>(window)) + 1e-5 * static_cast<double>(window);
}

/// The same motion, once by increments on the wire's side, once by absolute values straight into the participant.
TEST(Session, IncrementsAddUpToTheAbsoluteValues) {
  SpringMass served, direct;
  InProcess run(served, 1);
  run.coupler.start();
  LinkOutput output;
  direct.initialize(served.setup, output);
  direct.synchronise(Integration::explicit_central, {0.0}, output);
  double input = 0.0, force = 0.0;  // as the coupler accumulates them
  for (std::int64_t window = 1; window <= 1000; ++window) {
    const double increment = motion(window) - input;
    auto request = run.coupler.advance(increment);
    request.as<wire::Advance>().absolute_requested = window % 10 == 0;
    const auto& reply = run.coupler.ask(request);
    input += increment;
    force += reply.as<wire::Advanced>().increment.data.at(0);
    direct.advance(window, {motion(window)}, output);
    direct.accept();
    EXPECT_NEAR(force, output.value[0], 1e-12);
    ASSERT_EQ(reply.as<wire::Advanced>().absolute.rows, window % 10 == 0 ? 1 : 0);
    if (reply.as<wire::Advanced>().absolute.rows == 0) continue;
    EXPECT_NEAR(reply.as<wire::Advanced>().absolute.data[0], force, 1e-15);
    force = reply.as<wire::Advanced>().absolute.data[0];
  }
  EXPECT_GT(std::abs(force), 1e-2);
}

TEST(Session, AbsoluteInputReplacesTheAccumulatedOne) {
  SpringMass served, direct;
  InProcess run(served, 1);
  run.coupler.start();
  LinkOutput output;
  direct.initialize(served.setup, output);
  direct.synchronise(Integration::explicit_central, {0.0}, output);
  for (std::int64_t window = 1; window <= 20; ++window) {
    auto request = run.coupler.advance(1e-4 * 1.25);  // a coupler that accumulates wrongly
    request.as<wire::Advance>().absolute_requested = true;
    request.as<wire::Advance>().link_absolute.resize(1, 1);
    request.as<wire::Advance>().link_absolute.data = {1e-4 * static_cast<double>(window)};
    const auto reply = run.coupler.ask(request);
    direct.advance(window, {1e-4 * static_cast<double>(window)}, output);
    direct.accept();
    EXPECT_EQ(reply.as<wire::Advanced>().absolute.data, output.value);
  }
  // Largest at the first window: 1.25e-4 accumulated, 1e-4 told.
  EXPECT_NEAR(run.coupler.ask(Kind::finish).as<wire::Finished>().largest_drift, 0.25, 1e-12);
}

TEST(Session, DriftOfAnHonestCouplerIsRounding) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.start();
  double input = 0.0;
  for (std::int64_t window = 1; window <= 1000; ++window) {
    const double increment = motion(window) - input;
    auto request = run.coupler.advance(increment);
    input += increment;
    if (window % 100 == 0) {
      request.as<wire::Advance>().link_absolute.resize(1, 1);
      request.as<wire::Advance>().link_absolute.data = {motion(window)};
      input = motion(window);
    }
    run.coupler.ask(request);
  }
  EXPECT_LT(run.coupler.ask(Kind::finish).as<wire::Finished>().largest_drift, 1e-15);
}

TEST(Session, ARepeatedWindowIsTheSameBitByBit) {
  SpringMass spring;
  InProcess run(spring, 1);
  run.coupler.start();
  for (std::int64_t window = 1; window <= 50; ++window) {
    const double increment = motion(window) - motion(window - 1);
    const double first =
        run.coupler.ask(run.coupler.advance(increment, false)).as<wire::Advanced>().increment.data.at(0);
    const double other =
        run.coupler.ask(run.coupler.advance(2.0 * increment + 1e-6, false)).as<wire::Advanced>().increment.data.at(0);
    const double again =
        run.coupler.ask(run.coupler.advance(increment, false)).as<wire::Advanced>().increment.data.at(0);
    const double final =
        run.coupler.ask(run.coupler.advance(increment, true)).as<wire::Advanced>().increment.data.at(0);
    EXPECT_EQ(first, again);
    EXPECT_EQ(first, final);
    EXPECT_NE(first, other);
  }
}

TEST(Session, ATrialThatIsAcceptedEqualsOneAcceptedAtOnce) {
  SpringMass one, two;
  InProcess at_once(one, 1), on_request(two, 1);
  at_once.coupler.start();
  on_request.coupler.start();
  for (std::int64_t window = 1; window <= 20; ++window) {
    const double increment = motion(window) - motion(window - 1);
    auto request = at_once.coupler.advance(increment);
    request.as<wire::Advance>().records_requested = true;
    auto expected = at_once.coupler.ask(request);
    request = on_request.coupler.advance(increment, false);
    request.as<wire::Advance>().records_requested = true;
    const auto trial = on_request.coupler.ask(request);
    EXPECT_EQ(trial.as<wire::Advanced>().increment.data, expected.as<wire::Advanced>().increment.data);
    EXPECT_EQ(trial.as<wire::Advanced>().records.rows, window == 1 ? 1 : 0)
        << "the row of the start; a trial leaves none";
    if (window == 1)
      expected.as<wire::Advanced>().records.data.erase(expected.as<wire::Advanced>().records.data.begin(),
                                                       expected.as<wire::Advanced>().records.data.begin() + 3);
    ++on_request.coupler.window;
    request = on_request.coupler.request(Kind::accept);
    request.as<wire::Accept>().records_requested = true;
    const auto& accepted = on_request.coupler.ask(request);
    EXPECT_EQ(accepted.kind, Kind::accepted);
    EXPECT_EQ(accepted.as<wire::Accepted>().records.data, expected.as<wire::Advanced>().records.data);
  }
}

/// A mass that is pulled by the interface force: m a = -F, integrated by the trapezoidal rule with an explicit force.
class FreeMass : public Participant {
 public:
  Description describe() override {
    Description d;
    d.name = "spring";  // the name the scripted coupler welcomes
    d.role = Role::implicit_solver;
    d.interface_body = {0};
    d.interface_position_m = {0.0};
    d.interface_mass_kg = {2.0};
    d.bodies = {"rod"};
    return d;
  }
  void initialize(const Setup& setup, LinkOutput& output) override {
    dt_ = setup.clock.size_s();
    output.value = {u_};
  }
  void synchronise(Integration, const std::vector<double>& force, LinkOutput& output) override {
    a_ = -force[0] / 2.0;
    output = {{u_}, {v_}, {a_}};
  }
  void advance(std::int64_t, const std::vector<double>& force, LinkOutput& output) override {
    trial_ = {u_ + dt_ * v_ + 0.5 * dt_ * dt_ * a_, 0.0, -force[0] / 2.0};
    trial_[1] = v_ + 0.5 * dt_ * (a_ + trial_[2]);
    output = {{trial_[0]}, {trial_[1]}, {trial_[2]}};
  }
  void accept() override { u_ = trial_[0], v_ = trial_[1], a_ = trial_[2]; }
  void record(std::vector<double>&) override {}

 private:
  double dt_ = 0.0, u_ = 0.0, v_ = 1.0, a_ = 0.0;
  std::vector<double> trial_;
};

TEST(Session, TwoInOneProcessMakeACoupledOscillator) {
  SpringMass spring;
  FreeMass mass;
  InProcess explicit_side(spring, 1), implicit_side(mass, 1);
  explicit_side.coupler.start();
  implicit_side.coupler.ask(Kind::describe);
  implicit_side.coupler.driven_by = "force";
  implicit_side.coupler.ask(implicit_side.coupler.initialize());
  const auto& start = implicit_side.coupler.ask(implicit_side.coupler.synchronise(0.0)).as<wire::Synchronised>();
  ASSERT_EQ(start.velocity_m_s.rows, 1);
  double u = start.absolute.data[0], v = start.velocity_m_s.data[0], a = start.acceleration_m_s2.data[0];
  double sent_u = 0.0, sent_force = 0.0, force = 0.0;
  constexpr double dt = 0.01;
  for (int n = 0; n < 400; ++n) {
    const double predicted = u + dt * v + 0.5 * dt * dt * a;
    force += explicit_side.coupler.ask(explicit_side.coupler.advance(predicted - sent_u))
                 .as<wire::Advanced>()
                 .increment.data[0];
    sent_u = predicted;
    const auto& reply = implicit_side.coupler.ask(implicit_side.coupler.advance(force - sent_force));
    const auto& motion_of = reply.as<wire::Advanced>();
    sent_force = force;
    u += motion_of.increment.data[0];
    v = motion_of.velocity_m_s.data[0];
    a = motion_of.acceleration_m_s2.data[0];
  }
  // m1 = 1 kg, m2 = 2 kg, k = 100 N/m: u2 = V t + (v0 - V)/w sin(w t), V = 2/3 m/s, w^2 = k (1/m1 + 1/m2).
  const double w = std::sqrt(150.0), t = 4.0;
  EXPECT_NEAR(u, 2.0 / 3.0 * t + (1.0 / 3.0) / w * std::sin(w * t), 2e-3);
}

}  // namespace
}  // namespace ricochet::participant
