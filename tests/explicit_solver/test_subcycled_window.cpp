#include <gtest/gtest.h>

#include "explicit_solver/explicit_solver.hpp"
#include "explicit_solver/subcycled_window.hpp"
#include "tests/support/places.hpp"

namespace ricochet::explicit_solver {
namespace {

/// The explicit parts of kim_impact (axis and interface meet: some shared dofs are held), or with gravity a loaded one.
struct Parts {
  explicit Parts(bool loaded = false) {
    auto scene = scene::load_scene(test::source_folder() + "/configs/kim_impact.toml");
    for (auto& body : scene.bodies)
      body.gravity_m_s2 = loaded ? std::vector<double>{0.0, 1e6} : std::vector<double>{0.0, 0.0};
    problem = scene::build_problem(scene);
    states = solver::initial_states(problem, problem.scene.participant("explicit"), true);
  }
  scene::Problem problem;
  std::vector<solver::BodyState> states;
};

Eigen::VectorXd pattern(Eigen::Index size, double scale) {
  Eigen::VectorXd force(size);
  for (Eigen::Index i = 0; i < size; ++i) force[i] = scale * std::sin(1.0 + 0.7 * static_cast<double>(i));
  return force;
}

/// Force on held dofs is 0: their multiplier is the support's affair.
Eigen::VectorXd on_free(const solver::BodyState& state, double scale) {
  Eigen::VectorXd force = pattern(static_cast<Eigen::Index>(state.shared_dofs.size()), scale);
  for (std::size_t i = 0; i < state.shared_dofs.size(); ++i) {
    if (state.inverse_mass[state.shared_dofs[i]] == 0.0) force[static_cast<Eigen::Index>(i)] = 0.0;
  }
  return force;
}

class Substeps : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(Substeps, ACorrectedTrialEqualsOneComputedInFull) {
  const auto [m, loaded] = GetParam();
  Parts parts(loaded);
  auto direct_state = parts.states.front(), corrected_state = direct_state;
  const double dt = 5.4e-8;
  SubcycledWindow direct(direct_state, m, dt), corrected(corrected_state, m, dt);
  const Eigen::VectorXd none = 0.0 * on_free(direct_state, 1.0);
  direct.start(direct_state, 0.0, none);
  corrected.start(corrected_state, 0.0, none);
  for (int n = 0; n < 6; ++n) {
    const double begin = n * m * dt;
    const Eigen::VectorXd force = on_free(direct_state, 1e3 * (n + 1));
    direct.advance(direct_state, begin, m, force);
    corrected.advance(corrected_state, begin, m, on_free(direct_state, -7e3));
    corrected.advance(corrected_state, begin, m, 0.5 * force);
    corrected.advance(corrected_state, begin, m, force);
    for (std::size_t i = 0; i < direct_state.shared_dofs.size(); ++i) {
      EXPECT_NEAR(direct.shared_motion(direct_state, i).velocity, corrected.shared_motion(corrected_state, i).velocity,
                  1e-11);
    }
    direct.accept(direct_state);
    corrected.accept(corrected_state);
  }
  EXPECT_LT((direct_state.u - corrected_state.u).norm(), 1e-12 * direct_state.u.norm());
  EXPECT_LT((direct_state.v - corrected_state.v).norm(), 1e-12 * direct_state.v.norm());
  EXPECT_LT((direct_state.a - corrected_state.a).norm(), 1e-10 * direct_state.a.norm());
  EXPECT_LT((direct.internal() - corrected.internal()).norm(), 1e-10 * direct.internal().norm());
  const auto& a = direct_state.totals;
  const auto& b = corrected_state.totals;
  EXPECT_GT(std::abs(a.energy_interface_j), 0.0);
  EXPECT_NEAR(a.energy_interface_j, b.energy_interface_j, 1e-11 * std::abs(a.energy_interface_j));
  EXPECT_NEAR(a.energy_external_j, b.energy_external_j, 1e-11 * std::abs(a.energy_external_j));
  EXPECT_NEAR(a.impulse_n_kg_m_s, b.impulse_n_kg_m_s, 1e-11 * std::abs(a.impulse_n_kg_m_s));
  EXPECT_NEAR(a.impulse_t_kg_m_s, b.impulse_t_kg_m_s, 1e-11 * std::abs(a.impulse_t_kg_m_s)) << "of the axis";
}

INSTANTIATE_TEST_SUITE_P(OneAndMore, Substeps, testing::Combine(testing::Values(1, 2, 3, 7), testing::Bool()));

/// The work of the link is what the part gains in the staggered metric; loads and supports do none here.
TEST(SubcycledWindow, GainsTheWorkOfTheLink) {
  Parts parts;
  auto& state = parts.states.front();
  const double dt = 5.4e-8;
  SubcycledWindow window(state, 4, dt);
  window.start(state, 0.0, on_free(state, 0.0));
  const auto energy = [&] {
    return 0.5 * (state.mass.array() * (state.v.array().square() - 0.25 * dt * dt * state.a.array().square())).sum() +
           0.5 * state.u.dot(window.internal());
  };
  const double before = energy();
  for (int n = 0; n < 20; ++n) {
    window.advance(state, 4 * n * dt, 4, on_free(state, 2e3 * std::sin(0.9 * n)));
    window.advance(state, 4 * n * dt, 4, on_free(state, 1e3 * std::sin(0.9 * n)));
    window.accept(state);
  }
  EXPECT_NEAR(energy() - before, state.totals.energy_interface_j, 1e-10 * before);
  EXPECT_GT(std::abs(state.totals.energy_interface_j), 1e-7 * before);
}

}  // namespace
}  // namespace ricochet::explicit_solver
