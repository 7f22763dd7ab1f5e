#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "tests/support/places.hpp"

namespace ricochet::explicit_solver {
namespace {

scene::Problem problem(const std::string& config) {
  return scene::build_problem(scene::load_scene(test::source_folder() + "/configs/" + config + ".toml"));
}

participant::Setup setup_of(const scene::Problem& p, const participant::Description& description) {
  participant::Setup setup;
  setup.clock = p.clock;
  setup.interface_mass_kg = description.interface_mass_kg;
  return setup;
}

struct Started {
  explicit Started(const std::string& config) : given(problem(config)), solver(given, "explicit") {
    description = solver.describe();
    solver.initialize(setup_of(given, description), output);
    const std::vector<double> rest(output.value.size(), 0.0);
    solver.synchronise(participant::Integration::implicit_newmark, rest, output);
  }
  scene::Problem given;
  ExplicitSolver solver;
  participant::Description description;
  participant::LinkOutput output;
};

TEST(ExplicitSolver, RefusesTheRoleOfTheOther) {
  try {
    ExplicitSolver(problem("two_bars"), "implicit");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("role \"implicit\""));
  }
}

TEST(ExplicitSolver, DescribesItsSharedNodesBodyByBody) {
  Started run("kim_impact");
  EXPECT_EQ(run.description.interface_body.size(), 22U) << "11 nodes across, two bodies";
  EXPECT_EQ(run.description.interface_position_m.size(), 44U);
  EXPECT_THAT(run.description.bodies, testing::ElementsAre("steel", "carbide"));
  EXPECT_FALSE(run.description.contact_owner);
  EXPECT_GT(run.description.critical_time_step_s, run.given.clock.size_s());
}

TEST(ExplicitSolver, ATrialRepeatedGivesTheSameBitsAndLeavesNoTrace) {
  Started a("kim_impact"), b("kim_impact");
  std::vector<double> push(a.output.value.size()), other(push.size());
  for (std::size_t i = 0; i < push.size(); ++i) push[i] = 1e-9 * static_cast<double>(i), other[i] = -3e-9;
  for (int window = 1; window <= 5; ++window) {
    a.solver.advance(window, push, a.output);
    b.solver.advance(window, other, b.output);
    b.solver.advance(window, push, b.output);
    EXPECT_EQ(a.output.value, b.output.value);
    a.solver.accept();
    b.solver.accept();
  }
  std::vector<double> row_a, row_b;
  a.solver.record(row_a);
  b.solver.record(row_b);
  EXPECT_EQ(row_a, row_b);
}

TEST(ExplicitSolver, SharedNodesPushBackWithTheInternalForce) {
  Started run("two_bars");
  const double delta = 1e-6, stiffness = 206.8e9 * 6.4516e-4 / (0.254 / 20);
  run.solver.advance(1, {delta, 0.0}, run.output);
  // The neighbours fly on with 5.13588 m/s for one window before they notice.
  EXPECT_NEAR(run.output.value[0], stiffness * (delta - 5.13588 * 2.226e-6), 1e-6 * stiffness * delta);
}

TEST(ExplicitSolver, NamesBodyNodeAndWindowOfANumberThatIsNotFinite) {
  Started run("two_bars");
  run.solver.advance(1, {std::numeric_limits<double>::infinity(), 0.0}, run.output);
  run.solver.accept();
  std::vector<double> row;
  try {
    run.solver.record(row);
    FAIL();
  } catch (const SolverError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("window 1"), testing::HasSubstr("body 'left'")));
  }
}

}  // namespace
}  // namespace ricochet::explicit_solver
