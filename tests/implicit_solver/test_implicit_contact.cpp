#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "tests/support/contact_trial.hpp"
#include "tests/support/scene_file.hpp"

// The contact of the implicit side on one row that is no node pair.

namespace ricochet::implicit_solver {
namespace {

using test::Trial;
constexpr double dt = Trial::dt;

/// Plates that meet at (1, rate_n) m/s on one row.
test::ContactPlates meeting(const std::string& keys = "", double rate_n = 4.0) {
  test::ContactPlates plates("all_implicit", keys);
  plates.use_one_row();
  plates.set_velocity(0, {0.5, 0.75 * rate_n});
  plates.set_velocity(1, {-0.5, -0.25 * rate_n});
  return plates;
}

TEST(ImplicitContact, ClosesTheGapOfAnyRowAndLeavesNoRelativeVelocityAndKeepsMomentum) {
  Trial trial(meeting());
  const Eigen::Vector2d before = trial.momentum();
  trial.solve();
  EXPECT_EQ(trial.contact->root_dofs().size(), 3U) << "the row's three nodes along n";
  EXPECT_NEAR(trial.gap(), 0.0, 1e-20);
  const auto& normal = trial.plates.surface.pairs[0].normal;
  EXPECT_NEAR(trial.along(normal, trial.velocity), 0.0, 1e-14);
  EXPECT_NEAR(trial.along(normal, trial.acceleration), 0.0, 1e-7) << "of accelerations of 1e7 m/s^2";
  EXPECT_LT((trial.momentum() - before).norm(), 1e-13 * before.norm());
}

TEST(ImplicitContact, LeavesASeparatingRowAlone) {
  Trial trial(meeting("", -4.0));
  const Eigen::VectorXd before = trial.velocity;
  trial.solve();
  EXPECT_EQ(trial.contact->root_force().norm(), 0.0);
  EXPECT_EQ(trial.velocity, before);
}

// 1 m/s along t against 4 m/s along n: the impulse that holds it lies inside the cone from mu = 1/4 on.
TEST(ImplicitContact, HoldsOrSlipsByTheConeOfTheRow) {
  for (const auto& [mu, rate_after] : {std::pair{"0.2", 0.2}, std::pair{"0.3", 0.0}}) {
    Trial trial(meeting(std::string("friction_coefficient = ") + mu + "\n"));
    const Eigen::Vector2d before = trial.momentum();
    trial.solve();
    const auto& tangent = trial.plates.surface.pairs[0].tangent;
    EXPECT_NEAR(std::abs(trial.along(tangent, trial.velocity)), rate_after, 1e-13) << mu;
    EXPECT_LT((trial.momentum() - before).norm(), 1e-13 * before.norm()) << mu;
  }
}

TEST(ImplicitContact, ReportsTheImpulseOfTheWindowAsItsForce) {
  Trial trial(meeting());
  trial.solve();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(trial.mass.size());
  trial.contact->account(trial.plates.states, trial.increment, zero);
  trial.contact->accept();
  // p = 4 m/s / (N M^-1 N^T)
  const double impulse = 4.0 / trial.plates.surface.pairs[0].normal.inverse_mass(trial.plates.states);
  const auto report = trial.contact->report(trial.plates.states);
  EXPECT_NEAR(report.contact_force_n, impulse / dt, 1e-12 * impulse / dt);
  EXPECT_NEAR(report.contact_impulse_n_s, impulse, 1e-12 * impulse);
  EXPECT_EQ(report.pairs_stick + report.pairs_slip, 1);
}

/// Two blocks that turn and press each other with friction. S^-1 has another size along x than along y, and
/// couples all.
struct TurningBlocks {
  TurningBlocks()
      : problem(build()), states(solver::initial_states(problem, problem.scene.participant("implicit"), true)) {
    const Eigen::MatrixXd noise = Eigen::MatrixXd::Random(size(), size());
    inverse = 0.02 * noise * noise.transpose();
    for (Eigen::Index i = 0; i < size(); ++i) inverse(i, i) += i % 2 == 0 ? 1.0 : 2.0;
  }
  static scene::Problem build() {
    const test::TemporaryFolder folder;
    const std::string steel = "{ youngs_modulus_pa = 200e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }";
    return scene::build_problem(scene::load_scene(folder.write(
        "model = \"plane_strain\"\n[[body]]\nname = \"lower\"\nlarge_rotation = true\nmaterial = " + steel +
        "\nmesh = { start_m = -0.01, length_m = 0.01, height_m = 0.01, elements = [3, 5] }\n[[body]]\nname = "
        "\"upper\"\nlarge_rotation = true\ninitial_velocity_m_s = [1.0, -3.0]\nmaterial = " +
        steel +
        "\nmesh = { length_m = 0.01, height_m = 0.01, elements = [3, 4] }\n[contact]\nsurfaces = [\"lower.end\", "
        "\"upper.start\"]\nfriction_coefficient = 0.3\n[time]\nstep_s = 1e-7\nend_s = 1e-6\n"
        "[coupling]\nprotocol = \"all_implicit\"\n")));
  }
  [[nodiscard]] ImplicitContact contact() const { return {problem, solver::ContactSurface(problem, states), states}; }
  [[nodiscard]] Eigen::Index size() const { return std::ssize(contact().root_dofs()); }
  /// T over the root dofs.
  [[nodiscard]] Eigen::MatrixXd turn_of_root(const std::vector<Eigen::Matrix3d>& by) const {
    const auto root = contact().root_dofs();
    const int second = states[0].part.dofs();
    Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(size(), size());
    for (std::size_t i = 0; i < root.size(); ++i)
      for (std::size_t j = 0; j < root.size(); ++j)
        if (root[i] / 2 == root[j] / 2)
          turn(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
              by[root[i] < second ? 0 : 1](root[i] % 2, root[j] % 2);
    return turn;
  }
  /// Forces on the root dofs in a window in which nothing else moves the blocks.
  [[nodiscard]] Eigen::VectorXd forces(ImplicitContact& contact) const {
    Eigen::VectorXd increment(states[0].part.dofs() + states[1].part.dofs());
    increment << 1e-7 * states[0].v, 1e-7 * states[1].v;
    contact.solve(states, increment, false);
    return contact.root_force();
  }

  scene::Problem problem;
  std::vector<solver::BodyState> states;
  Eigen::MatrixXd inverse;
};

TEST(TurnedContact, HasTheForcesThatATurnedInverseGives) {
  const TurningBlocks blocks;
  const auto turn = [](double angle) { return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix(); };
  const std::vector<Eigen::Matrix3d> by = {turn(0.4), turn(-0.9)}, once = {turn(1.0), turn(2.0)};
  const Eigen::MatrixXd root_turn = blocks.turn_of_root(by);
  ImplicitContact anew = blocks.contact(), turned = blocks.contact(), by_products = blocks.contact();
  anew.prepare(root_turn * blocks.inverse * root_turn.transpose(), 1e-7);
  const Eigen::VectorXd expected = blocks.forces(anew);
  ASSERT_GT(expected.norm(), 0.0);
  turned.prepare(blocks.inverse, 1e-7);
  by_products.prepare(
      blocks.states, [&](const Eigen::VectorXd& f, Eigen::VectorXd& x) { x = blocks.inverse * f; }, 1e-7);
  EXPECT_GT((blocks.forces(turned) - expected).norm(), 1e-2 * expected.norm()) << "the turn matters";
  for (ImplicitContact* contact : {&turned, &by_products}) {
    contact->turn(once, blocks.states);
    (void)blocks.forces(*contact);
    contact->turn(by, blocks.states);
    EXPECT_LT((blocks.forces(*contact) - expected).norm(), 1e-8 * expected.norm());
  }
}

// The first guess has a force for each of them.
TEST(ImplicitContact, KeepsItsRowsWhileItSolvesAWindowAgain) {
  TurningBlocks blocks;
  ImplicitContact contact = blocks.contact();
  contact.prepare(blocks.inverse, 1e-7);
  ASSERT_GT(blocks.forces(contact).norm(), 0.0);
  const auto pairs = contact.surface().pairs;
  Eigen::VectorXd increment(blocks.states[0].part.dofs() + blocks.states[1].part.dofs());
  increment << 1e-7 * blocks.states[0].v, 1e-7 * blocks.states[1].v;
  for (Eigen::Index dof = 0; dof < blocks.states[1].u.size(); dof += 2) blocks.states[1].u[dof] += 0.007;
  contact.solve(blocks.states, increment, true);
  ASSERT_EQ(contact.surface().pairs.size(), pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto &now = contact.surface().pairs[i].normal.entries, &then = pairs[i].normal.entries;
    ASSERT_EQ(now.size(), then.size());
    for (std::size_t e = 0; e < now.size(); ++e) EXPECT_EQ(now[e].dof, then[e].dof);
  }
  contact.solve(blocks.states, increment, false);
  EXPECT_LT(contact.surface().pairs.size(), pairs.size()) << "another window: what has slid off has no rows";
}

}  // namespace
}  // namespace ricochet::implicit_solver
