#include <gtest/gtest.h>

#include "implicit_solver/contact/implicit_contact.hpp"
#include "tests/support/contact_plates.hpp"

// The contact of the implicit side on one row that is no node pair. The operator is M alone, as for a very short
// window, so that everything can be worked out from the row.

namespace ricochet::implicit_solver {
namespace {

constexpr double dt = 1e-6;

/// Plates that meet at (1, 4) m/s, their contact, and a trial's increments and rates.
struct Trial {
  test::ContactPlates plates;
  std::optional<ImplicitContact> contact;
  Eigen::VectorXd mass, increment, velocity, acceleration, bracket;

  explicit Trial(const std::string& keys = "", double rate_n = 4.0) : plates("all_implicit", keys) {
    plates.use_one_row();
    plates.set_velocity(0, {0.5, 0.75 * rate_n});
    plates.set_velocity(1, {-0.5, -0.25 * rate_n});
    contact.emplace(plates.problem, plates.surface, plates.states);
    const auto& states = plates.states;
    mass.resize(states[0].mass.size() + states[1].mass.size());
    mass << states[0].mass, states[1].mass;
    velocity.resizeLike(mass);
    velocity << states[0].v, states[1].v;
    acceleration = Eigen::VectorXd::Zero(mass.size());
    bracket = acceleration;
    increment = dt * velocity;
    const auto& root = contact->root_dofs();
    Eigen::MatrixXd root_inverse =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(root.size()), static_cast<Eigen::Index>(root.size()));
    for (std::size_t i = 0; i < root.size(); ++i)
      root_inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = 1.0 / mass[root[i]];
    contact->prepare(root_inverse, dt);
  }
  void solve() {
    contact->solve(plates.states, increment);
    const auto& root = contact->root_dofs();
    for (std::size_t i = 0; i < root.size(); ++i) {
      const double a = contact->root_force()[static_cast<Eigen::Index>(i)] / mass[root[i]];
      increment[root[i]] += contact->kappa() * 0.25 * dt * dt * a;
      // the trapezoidal rule's: du = dt v + dt^2/4 (a_n + a_{n+1}), v_{n+1} = v_n + dt/2 (a_n + a_{n+1})
      acceleration[root[i]] = a;
      velocity[root[i]] += 0.5 * dt * a;
      bracket[root[i]] = contact->root_force()[static_cast<Eigen::Index>(i)];
    }
    contact->update_rates(plates.states, bracket, increment, velocity, acceleration);
  }
  [[nodiscard]] double along(const solver::ContactRow& row, const Eigen::VectorXd& values) const {
    const auto second = plates.states[0].part.dofs();
    return row.times([&](int part) { return values.data() + part * second; });
  }
  [[nodiscard]] double gap() const { return along(plates.surface.pairs[0].normal, increment); }
  [[nodiscard]] Eigen::Vector2d momentum() const {
    Eigen::Vector2d sum(0.0, 0.0);
    for (Eigen::Index dof = 0; dof < mass.size(); ++dof) sum[dof % 2] += mass[dof] * velocity[dof];
    return sum;
  }
};

TEST(ImplicitContact, ClosesTheGapOfAnyRowAndLeavesNoRelativeVelocityAndKeepsMomentum) {
  Trial trial;
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
  Trial trial("", -4.0);
  const Eigen::VectorXd before = trial.velocity;
  trial.solve();
  EXPECT_EQ(trial.contact->root_force().norm(), 0.0);
  EXPECT_EQ(trial.velocity, before);
}

// 1 m/s along t against 4 m/s along n: the impulse that holds it lies inside the cone from mu = 1/4 on.
TEST(ImplicitContact, HoldsOrSlipsByTheConeOfTheRow) {
  for (const auto& [mu, rate_after] : {std::pair{"0.2", 0.2}, std::pair{"0.3", 0.0}}) {
    Trial trial(std::string("friction_coefficient = ") + mu + "\n");
    const Eigen::Vector2d before = trial.momentum();
    trial.solve();
    const auto& tangent = trial.plates.surface.pairs[0].tangent;
    EXPECT_NEAR(std::abs(trial.along(tangent, trial.velocity)), rate_after, 1e-13) << mu;
    EXPECT_LT((trial.momentum() - before).norm(), 1e-13 * before.norm()) << mu;
  }
}

TEST(ImplicitContact, ReportsTheImpulseOfTheWindowAsItsForce) {
  Trial trial;
  trial.solve();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(trial.mass.size());
  trial.contact->account(trial.plates.states, trial.bracket, trial.increment, zero, zero);
  trial.contact->accept();
  // p = 4 m/s / (N M^-1 N^T)
  const double impulse = 4.0 / trial.plates.surface.pairs[0].normal.inverse_mass(trial.plates.states);
  const auto report = trial.contact->report(trial.plates.states);
  EXPECT_NEAR(report.contact_force_n, impulse / dt, 1e-12 * impulse / dt);
  EXPECT_NEAR(report.contact_impulse_n_s, impulse, 1e-12 * impulse);
  EXPECT_EQ(report.pairs_stick + report.pairs_slip, 1);
}

}  // namespace
}  // namespace ricochet::implicit_solver
