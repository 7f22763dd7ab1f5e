// An operator that is not the same for the whole run: bars whose force is not linear, and which press on a stop.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "implicit_solver/implicit_solver.hpp"
#include "tests/support/cubic_bars.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::implicit_solver {
namespace {

constexpr int windows = 60;

/// A bar of six elements that flies against a stop; its strains are about 0.01, where the cubic term is ten times the
/// linear one.
scene::Problem bar_on_stop(const std::string& law, const std::string& protocol = "all_implicit") {
  const test::TemporaryFolder folder;
  return scene::build_problem(scene::load_scene(folder.write(R"(model = "bar"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }
mesh = { length_m = 6.0, elements = 6 }
initial_velocity_m_s = [0.01]
[contact]
surfaces = ["rod.end", "rigid_plane"]
initial_gap_m = 1e-4
)" + law + R"(
[time]
step_s = 0.05
end_s = 3.0
[coupling]
protocol = ")" + protocol + "\"\n")));
}

/// Answers of a run at its end.
struct End {
  Eigen::VectorXd motion;  ///< u, v of all nodes
  std::vector<double> pressed_n;
  int tangents = 0;
};

struct BarRun {
  explicit BarRun(const std::string& law, const std::string& protocol = "all_implicit")
      : given(bar_on_stop(law, protocol)), solver(given, "implicit", {}, [this](const auto& state) {
          auto bars = std::make_unique<test::CubicBars>(state);
          force = bars.get();
          return bars;
        }) {
    (void)solver.describe();
    participant::Setup setup;
    setup.clock = given.clock;
    setup.last_window = windows;
    setup.interface_mass_kg.assign(protocol == "all_implicit" ? 0 : 1, 1.0);
    solver.initialize(setup, output);
    solver.synchronise(participant::Integration::implicit_newmark, std::vector<double>(setup.interface_mass_kg.size()),
                       output);
  }
  void step(const std::vector<double>& force = {}) {
    solver.advance(++window, force, output);
    if (idle_before_acceptance) solver.work_ahead();
    solver.accept();
    std::vector<double> row;
    solver.contact_forces(row);
    pressed_n.push_back(row.front());
  }
  void linearise_here() {
    auto state = solver.state();
    state.linearised_at = state.bodies.front().u;
    solver.restore(state);
  }
  [[nodiscard]] End end() const {
    const auto body = solver.state().bodies.front();
    End end{Eigen::VectorXd(2 * body.u.size()), pressed_n, force->tangents};
    end.motion << body.u, body.v;
    return end;
  }
  scene::Problem given;
  test::CubicBars* force = nullptr;
  ImplicitSolver solver;
  participant::LinkOutput output;
  std::vector<double> pressed_n;
  int window = 0;
  bool idle_before_acceptance = false;
};

/// `every`: windows from one linearisation to the next; 0: where the solver wants one.
End run_with_operator_of(int every, const std::string& law) {
  BarRun run(law);
  for (int n = 0; n < windows; ++n) {
    if (every > 0 && n % every == 0) run.linearise_here();
    run.step();
  }
  return run.end();
}

class OperatorThatChanges : public testing::TestWithParam<std::string> {};

TEST_P(OperatorThatChanges, GivesTheAnswersOfOneComputedAnew) {
  const End anew = run_with_operator_of(1, GetParam());
  double pressed = 0.0;
  for (const double n : anew.pressed_n) pressed = std::max(pressed, std::abs(n));
  ASSERT_GT(pressed, 0.01) << "it presses on the stop";
  // The rest that is left out of balance, 1e-10, stays in forces that jump from window to window, as this law has them.
  const double share = GetParam().find("fully_implicit") != std::string::npos ? 1e-7 : 1e-9;
  for (const int every : {0, 3, 10}) {
    const End end = run_with_operator_of(every, GetParam());
    EXPECT_LT(end.tangents, anew.tangents) << every;
    EXPECT_LT((end.motion - anew.motion).lpNorm<Eigen::Infinity>(), share * anew.motion.lpNorm<Eigen::Infinity>())
        << every;
    for (std::size_t n = 0; n < end.pressed_n.size(); ++n)
      EXPECT_NEAR(end.pressed_n[n], anew.pressed_n[n], 10.0 * share * pressed) << every << ", window " << n + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, OperatorThatChanges,
                         testing::Values("multiplier_update = \"trapezoidal_reset\"",
                                         "multiplier_update = \"fully_implicit\"",
                                         "enforcement = \"penalty\"\npenalty_pa_m = 100.0"),
                         [](const auto& info) { return "law" + std::to_string(info.index); });

TEST(WindowSolver, AStatePutBackHasTheOperatorThatItWasComputedWith) {
  BarRun run("");
  for (int n = 0; n < 40; ++n) run.step();
  const auto state = run.solver.state();
  for (int n = 0; n < 20; ++n) run.step();
  const End first = run.end();
  run.solver.restore(state);
  run.window = 40;
  for (int n = 0; n < 20; ++n) run.step();
  EXPECT_EQ(run.end().motion, first.motion);
}

/// Input of a link, which is another force on the shared node in every trial.
TEST(WindowSolver, AWindowTriedAgainHasTheSameBits) {
  const std::string hybrid = "[partition]\nimplicit_length_m = { rod = 4.5 }\n";
  BarRun run(hybrid, "hughes_liu"), again(hybrid, "hughes_liu");
  again.idle_before_acceptance = true;
  for (int n = 1; n <= windows; ++n) {
    const std::vector<double> force{1e-3 * std::sin(0.1 * n)}, other{5e-2};
    again.solver.advance(n, other, again.output);
    again.step(force);
    run.step(force);
    again.solver.work_ahead();
    ASSERT_EQ(again.end().motion, run.end().motion) << n;
  }
}

/// After the switch the bodies fly by central differences, whose acceleration is that of the force itself.
TEST(FlightWindow, TakesTheForceOfElementsThatAreNotLinear) {
  BarRun run("");
  for (int n = 0; n < 20; ++n) run.step();
  run.solver.synchronise(participant::Integration::explicit_central, {}, run.output);
  const auto pressed = run.solver.state().bodies.front();
  for (int n = 0; n < 5; ++n) run.step();
  auto body = run.solver.state().bodies.front();
  EXPECT_GT((body.u - pressed.u).lpNorm<Eigen::Infinity>(), 1e-4) << "it moves on";
  Eigen::VectorXd force = body.u;
  run.force->evaluate(0.0, body.u, force);
  const auto mass = solver::initial_states(run.given, run.given.scene.participants.front(), true).front().mass;
  EXPECT_LT((mass.cwiseProduct(body.a) + force).lpNorm<Eigen::Infinity>(), 1e-12 * force.lpNorm<Eigen::Infinity>());
}

/// Linear bars that count how often they are asked for K.
class CountingBars final : public solver::InternalForce {
 public:
  CountingBars(const solver::BodyState& state, int& tangents) : linear_(state), tangents_(tangents) {}
  void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override {
    linear_.evaluate(step_s, u, force);
  }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return linear_.rows(); }
  [[nodiscard]] bool linear() const override { return true; }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                              double half_work_j) const override {
    return linear_.stored(u, force, half_work_j);
  }
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override {
    ++tangents_;
    return linear_.tangent(u);
  }

 private:
  solver::LinearElements linear_;
  int& tangents_;
};

/// Up to the first window.
void begin(ImplicitSolver& solver, const scene::Problem& given, participant::LinkOutput& output) {
  (void)solver.describe();
  participant::Setup setup;
  setup.clock = given.clock;
  solver.initialize(setup, output);
  solver.synchronise(participant::Integration::implicit_newmark, {}, output);
}

TEST(WindowSolver, OfLinearElementsIsFactoredOnce) {
  const scene::Problem given = bar_on_stop("");
  int tangents = 0;
  ImplicitSolver solver(given, "implicit", {},
                        [&](const auto& state) { return std::make_unique<CountingBars>(state, tangents); });
  participant::LinkOutput output;
  begin(solver, given, output);
  for (int n = 1; n <= windows; ++n) {
    solver.advance(n, {}, output);
    solver.accept();
  }
  EXPECT_EQ(tangents, 1);
  EXPECT_EQ(solver.state().linearised_at.size(), 0);
}

/// A plate that turns by 1.2 rad: the operator follows it, and its factor is that of the start.
TEST(WindowSolver, OfAPartThatTurnsIsFactoredOnce) {
  const test::TemporaryFolder folder;
  const scene::Problem given = scene::build_problem(scene::load_scene(folder.write(R"(model = "plane_strain"
[[body]]
name = "plate"
material = { youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }
mesh = { length_m = 0.04, height_m = 0.01, elements = [8, 3] }
large_rotation = true
initial_angular_velocity_rad_s = 3000.0
[time]
step_s = 4e-6
end_s = 4e-4
[coupling]
protocol = "all_implicit"
)")));
  ImplicitSolver solver(given, "implicit");
  participant::LinkOutput output;
  begin(solver, given, output);
  const auto start = solver.state();
  for (int n = 1; n <= 100; ++n) {
    solver.advance(n, {}, output);
    solver.accept();
  }
  const auto end = solver.state();
  EXPECT_EQ(end.linearised_at, start.linearised_at);
  EXPECT_NEAR(std::atan2(end.directions[0](1, 0), end.directions[0](0, 0)), 1.2, 0.02);
}

/// A force that is another whatever the displacement: no window has one that is in balance.
class RandomBars final : public solver::InternalForce {
 public:
  explicit RandomBars(const solver::BodyState& state) : linear_(state) {}
  void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override {
    linear_.evaluate(step_s, u, force);
    sign_ = -sign_;
    force[2] += sign_;
  }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return linear_.rows(); }
  [[nodiscard]] bool linear() const override { return false; }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                              double half_work_j) const override {
    return linear_.stored(u, force, half_work_j);
  }
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override { return linear_.tangent(u); }

 private:
  solver::LinearElements linear_;
  double sign_ = 1.0;
};

TEST(WindowSolver, SaysWhereNewtonsIterationDoesNotSettle) {
  const scene::Problem given = bar_on_stop("");
  ImplicitSolver solver(given, "implicit", {}, [](const auto& state) { return std::make_unique<RandomBars>(state); });
  participant::LinkOutput output;
  begin(solver, given, output);
  try {
    solver.advance(1, {}, output);
    FAIL() << "it settled";
  } catch (const SolverError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("window 1: Newton's iteration does not settle: after 50 steps "));
    EXPECT_THAT(error.what(), testing::HasSubstr("at node 2 of body 'rod' (2, 0) m"));
    EXPECT_THAT(error.what(), testing::HasSubstr("use a smaller time.step_s"));
  }
}

TEST(WindowSolver, MasslessNodesAreRefusedWhereElementsAreNotLinear) {
  EXPECT_THROW(
      {
        try {
          const BarRun run("multiplier_update = \"massless\"");
        } catch (const ConfigError& error) {
          EXPECT_THAT(error.what(), testing::HasSubstr("contact.multiplier_update = \"massless\""));
          EXPECT_THAT(error.what(), testing::HasSubstr("its elements are not linear"));
          throw;
        }
      },
      ConfigError);
}

}  // namespace
}  // namespace ricochet::implicit_solver
