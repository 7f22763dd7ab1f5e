#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/scene/protocols.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "implicit_solver/implicit_solver.hpp"
#include "tests/support/places.hpp"

// A solver's State is all that its next windows are computed from: put back, they come out to the same bits, whatever
// was tried, accepted or prepared in between.

namespace ricochet {
namespace {

/// A solver that is the only participant of a scene of configs/, with its records.
template <class Solver>
struct Alone {
  static scene::Problem problem_of(const std::string& config, const std::string& protocol,
                                   scene::MultiplierUpdate law) {
    auto scene = scene::load_scene(test::source_folder() + "/configs/" + config + ".toml");
    scene.coupling.protocol = scene::protocol_traits(protocol);
    scene.contacts.front().multiplier_update = law;
    const auto role = protocol == "all_implicit" ? scene::Role::implicit_solver : scene::Role::explicit_solver;
    scene.participants = {{"alone", role, {}, "", scene::Start::launch, {}}};
    for (const auto& body : scene.bodies) scene.participants[0].bodies.push_back(body.name);
    return scene::build_problem(scene);
  }
  Alone(const std::string& config, const std::string& protocol, scene::MultiplierUpdate law)
      : problem(problem_of(config, protocol, law)), solver(problem, "alone") {
    (void)solver.describe();
    participant::Setup setup;
    setup.clock = problem.clock.size_s();
    setup.last_window = 100'000;
    solver.initialize(setup, output);
    solver.synchronise(participant::Integration::implicit_newmark, {}, output);
  }
  /// Rows of `count` windows, each tried twice and the one after it begun.
  std::vector<double> run(int count) {
    std::vector<double> rows;
    for (int i = 0; i < count; ++i) {
      ++window;
      solver.advance(window, {}, output);
      solver.advance(window, {}, output);
      solver.accept();
      solver.record(rows);
      solver.work_ahead();
    }
    return rows;
  }

  scene::Problem problem;
  Solver solver;
  participant::LinkOutput output;
  std::int64_t window = 0;
};

template <class Solver>
void expect_same_bits_after_restore(const std::string& config, const std::string& protocol,
                                    scene::MultiplierUpdate law) {
  Alone<Solver> alone(config, protocol, law);
  alone.run(30);
  const auto state = alone.solver.state();
  const auto window = alone.window;
  const auto first = alone.run(60);
  alone.solver.advance(alone.window + 1, {}, alone.output);  // a trial that is given up
  alone.solver.restore(state);
  alone.window = window;
  EXPECT_EQ(alone.run(60), first) << config << ", " << protocol;
}

using scene::MultiplierUpdate;

TEST(State, PutBackGivesTheSameBits) {
  for (const std::string config : {"two_bars", "sticking_plates", "slipping_plates", "rod_on_stop"}) {
    for (const auto law : {MultiplierUpdate::trapezoidal_reset, MultiplierUpdate::massless}) {
      expect_same_bits_after_restore<implicit_solver::ImplicitSolver>(config, "all_implicit", law);
      expect_same_bits_after_restore<explicit_solver::ExplicitSolver>(config, "all_explicit", law);
    }
    expect_same_bits_after_restore<implicit_solver::ImplicitSolver>(config, "all_implicit",
                                                                    MultiplierUpdate::fully_implicit);
  }
}

// Driven by force, in substeps, by a force that changes from trial to trial.
TEST(State, OfSubstepsPutBackGivesTheSameBits) {
  auto scene = scene::load_scene(test::source_folder() + "/configs/two_bars.toml");
  scene.coupling.protocol = scene::protocol_traits("prakash_hjelmstad");
  const auto problem = scene::build_problem(scene);
  explicit_solver::ExplicitSolver solver(problem, "explicit");
  participant::Setup setup;
  setup.interface_mass_kg = solver.describe().interface_mass_kg;
  setup.clock = problem.clock.size_s();
  setup.substeps = 2;
  setup.driven_by = participant::Drive::force;
  setup.last_window = 1000;
  participant::LinkOutput output;
  std::vector<double> force(setup.interface_mass_kg.size(), 0.0);  // of bars: a component a node
  solver.initialize(setup, output);
  solver.synchronise(participant::Integration::explicit_central, force, output);
  const auto run = [&](std::int64_t first, std::int64_t last) {
    std::vector<double> rows;
    for (auto window = first; window <= last; ++window) {
      for (double& f : force) f = 1e3 * std::sin(0.3 * static_cast<double>(window));
      solver.advance(window, force, output);
      for (double& f : force) f *= 1.1;
      solver.advance(window, force, output);
      solver.accept();
      solver.record(rows);
      solver.work_ahead();
    }
    return rows;
  };
  run(1, 10);
  const auto state = solver.state();
  const auto first = run(11, 40);
  solver.restore(state);
  solver.work_ahead();  // a window corrected from what was held is rounded otherwise than one computed at once
  EXPECT_EQ(run(11, 40), first);
}

}  // namespace
}  // namespace ricochet
