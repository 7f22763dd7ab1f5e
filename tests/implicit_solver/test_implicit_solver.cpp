#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "implicit_solver/implicit_solver.hpp"
#include "tests/support/places.hpp"

namespace ricochet::implicit_solver {
namespace {

scene::Problem baseline(const std::string& config, scene::MultiplierUpdate update) {
  auto scene = scene::load_scene(test::source_folder() + "/configs/" + config + ".toml");
  scene.coupling.protocol = scene::protocol_traits("all_implicit");
  scene.contacts.front().multiplier_update = update;
  scene.participants = {{"implicit", scene::Role::implicit_solver, {}, "", scene::Start::launch, {}}};
  for (const auto& body : scene.bodies) scene.participants[0].bodies.push_back(body.name);
  return scene::build_problem(scene);
}

struct Started {
  Started(const std::string& config, scene::MultiplierUpdate update)
      : given(baseline(config, update)), solver(given, "implicit") {
    (void)solver.describe();
    participant::Setup setup;
    setup.clock = given.clock.size_s();
    solver.initialize(setup, output);
    solver.synchronise(participant::Integration::implicit_newmark, {}, output);
  }
  void step() {
    solver.advance(++window, {}, output);
    solver.accept();
  }
  /// 1/2 v^T M v - dt^2/8 a^T M a + 1/2 u^T K u with a = -M^-1 K u: the metric in which central difference conserves
  /// energy.
  [[nodiscard]] double staggered_energy() const {
    double energy = 0.0;
    const double dt = given.clock.size_s();
    for (const auto& state : states()) {
      const Eigen::VectorXd force = state.part.stiffness * state.u;
      const Eigen::VectorXd a = -state.inverse_mass.cwiseProduct(force);
      energy += 0.5 * state.mass.dot(state.v.cwiseAbs2()) - dt * dt / 8.0 * state.mass.dot(a.cwiseAbs2()) +
                0.5 * state.u.dot(force);
    }
    return energy;
  }
  /// The bodies as the solver has them now.
  [[nodiscard]] std::vector<solver::BodyState> states() const {
    auto now = solver::initial_states(given, given.scene.participants.front(), true);
    solver::restore_motions(solver.state().bodies, now);
    return now;
  }
  scene::Problem given;
  ImplicitSolver solver;
  participant::LinkOutput output;
  int window = 0;
};

class SwitchAtSeparation : public testing::TestWithParam<scene::MultiplierUpdate> {};

TEST_P(SwitchAtSeparation, CostsNoEnergyInTheStaggeredMetric) {
  Started run("two_bars", GetParam());
  while (!run.solver.contact_status().separated && run.window < 200) run.step();
  ASSERT_TRUE(run.solver.contact_status().separated);
  const double before = run.staggered_energy();
  run.solver.synchronise(participant::Integration::explicit_central, {}, run.output);
  EXPECT_NEAR(run.staggered_energy(), before, 1e-10 * before);
  for (const auto& state : run.states()) {  // no stale contact force in a
    const Eigen::VectorXd a = -state.inverse_mass.cwiseProduct(Eigen::VectorXd(state.part.stiffness * state.u));
    EXPECT_LT((state.a - a).cwiseAbs().maxCoeff(), 1e-9 * a.cwiseAbs().maxCoeff());
  }
  for (int n = 0; n < 200; ++n) run.step();
  EXPECT_NEAR(run.staggered_energy(), before, 1e-10 * before) << "central difference conserves it";
}

INSTANTIATE_TEST_SUITE_P(MultiplierUpdates, SwitchAtSeparation,
                         testing::Values(scene::MultiplierUpdate::trapezoidal_reset,
                                         scene::MultiplierUpdate::fully_implicit));

TEST(ImplicitSolver, TheIncrementalResidualStaysTheResidual) {
  Started run("kim_impact", scene::MultiplierUpdate::trapezoidal_reset);
  ASSERT_EQ(run.given.scene.coupling.resynchronise_every, 100);
  for (int n = 0; n < 3 * 100 - 1; ++n) run.step();  // the next one would make it so
  const auto states = run.states();
  const auto forces = run.solver.state().forces;
  double drift = 0.0, scale = 0.0;
  Eigen::Index first = 0;
  for (const auto& state : states) {
    const Eigen::VectorXd internal = state.part.stiffness * state.u;
    for (int dof = 0; dof < state.part.dofs(); ++dof) {
      const double residual = forces.external[first + dof] - internal[dof] - forces.link[first + dof];
      scale = std::max(scale, std::abs(internal[dof]));
      drift = std::max(drift, std::abs(residual - forces.residual[first + dof]));
    }
    first += state.part.dofs();
  }
  EXPECT_LT(drift, 1e-10 * scale);
  EXPECT_GT(drift, 0.0) << "by increments, not anew";
}

TEST(ImplicitSolver, ATrialRepeatedGivesTheSameBits) {
  Started a("kim_impact", scene::MultiplierUpdate::trapezoidal_reset),
      b("kim_impact", scene::MultiplierUpdate::trapezoidal_reset);
  for (int n = 1; n <= 20; ++n) {
    a.step();
    b.solver.advance(n, {}, b.output);
    b.step();
  }
  std::vector<double> row_a, row_b;
  a.solver.record(row_a);
  b.solver.record(row_b);
  EXPECT_EQ(row_a, row_b);
}

TEST(ImplicitSolver, ClosedPairsMoveTogetherAndNeverPenetrate) {
  Started run("kim_impact", scene::MultiplierUpdate::trapezoidal_reset);
  for (int n = 0; n < 50; ++n) {
    run.step();
    EXPECT_GT(run.solver.contact_status().gap_min_m, -1e-15);
  }
  EXPECT_EQ(run.solver.contact_status().pairs_closed, 11);
}

TEST(ImplicitSolver, RefusesTheRoleOfTheOther) {
  const auto problem = scene::build_problem(scene::load_scene(test::source_folder() + "/configs/two_bars.toml"));
  EXPECT_THROW(ImplicitSolver(problem, "explicit"), ConfigError);
}

}  // namespace
}  // namespace ricochet::implicit_solver
