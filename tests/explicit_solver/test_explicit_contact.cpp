#include <gtest/gtest.h>

#include "explicit_solver/explicit_contact.hpp"
#include "tests/support/contact_plates.hpp"

// The contact law of all-explicit on one row that is no node pair: what it promises follows from the row alone.

namespace ricochet::explicit_solver {
namespace {

constexpr double dt = 1e-6;
const WindowClock clock_of_windows = dt;

Eigen::VectorXd next_displacement(const solver::BodyState& state) {
  return state.u + dt * state.v + 0.5 * dt * dt * state.a;
}

/// Gap of the row after the first step, with the accelerations that the contact has left.
double gap_after_a_step(const test::ContactPlates& plates) {
  const std::vector<Eigen::VectorXd> u = {next_displacement(plates.states[0]), next_displacement(plates.states[1])};
  return plates.surface.pairs[0].gap(
      [&](int part) -> const Eigen::VectorXd& { return u[static_cast<std::size_t>(part)]; });
}

auto accelerations(const std::vector<solver::BodyState>& states) {
  return [&states](int part) -> const Eigen::VectorXd& { return states[static_cast<std::size_t>(part)].a; };
}

test::ContactPlates meeting(const std::string& keys = "") {
  test::ContactPlates plates("all_explicit", keys);
  plates.use_one_row();
  plates.set_velocity(0, {0.5, 3.0});
  plates.set_velocity(1, {-0.5, -1.0});
  return plates;
}

TEST(ExplicitContact, ClosesTheGapOfAnyRowExactlyAndKeepsMomentum) {
  auto plates = meeting();
  ExplicitContact contact(plates.problem.scene.contact_law(), plates.surface, clock_of_windows);
  contact.start(plates.states);
  EXPECT_EQ(contact.pairs_closed(), 1);
  EXPECT_NEAR(gap_after_a_step(plates), 0.0, 1e-20);
  EXPECT_LT(plates.mass_times(accelerations(plates.states)).norm(), 1e-6) << "of forces of some 1e7 N";
  // r = rate / (dt/2 N M^-1 N^T), N M^-1 N^T = 1/m_lower + (1/m_left + 1/m_middle)/4, masses 5, 5 and 10 kg.
  const double inverse_mass = 1.0 / 5.0 + 0.25 * (1.0 / 5.0 + 1.0 / 10.0);
  EXPECT_NEAR(plates.surface.pairs[0].normal.inverse_mass(plates.states), inverse_mass, 1e-14);
  const int lower = plates.node_at(0, {0.1, 0.0});
  EXPECT_NEAR(plates.states[0].a[2 * lower + 1], -4.0 / (0.5 * dt * inverse_mass) / 5.0, 1.0);
}

TEST(ExplicitContact, LeavesASeparatingRowAlone) {
  auto plates = meeting();
  plates.set_velocity(1, {0.0, 3.5});
  ExplicitContact contact(plates.problem.scene.contact_law(), plates.surface, clock_of_windows);
  contact.start(plates.states);
  EXPECT_EQ(contact.pairs_closed(), 0);
  EXPECT_EQ(plates.states[0].a.norm(), 0.0);
  EXPECT_EQ(plates.states[1].a.norm(), 0.0);
}

// The relative velocity along t is (v_B - v_A) . t = 1 m/s, against 4 m/s along n: the cone holds it from mu = 1/4 on.
TEST(ExplicitContact, HoldsOrSlipsByTheConeOfTheRow) {
  for (const auto& [mu, state] :
       {std::pair{"0.2", solver::ContactState::slip}, std::pair{"0.3", solver::ContactState::stick}}) {
    auto plates = meeting(std::string("friction_coefficient = ") + mu + "\n");
    ExplicitContact contact(plates.problem.scene.contact_law(), plates.surface, clock_of_windows);
    contact.start(plates.states);
    const auto& pair = plates.surface.pairs[0];
    const double normal = pair.normal.times(accelerations(plates.states)),
                 tangential = pair.tangent.times(accelerations(plates.states));
    const double ratio = std::abs(tangential / normal);
    EXPECT_NEAR(ratio, state == solver::ContactState::slip ? 0.2 : 0.25, 1e-12) << mu;
    const double rate = pair.tangent.times(velocity_of(plates.states)) + 0.5 * dt * tangential;
    if (state == solver::ContactState::stick) {
      EXPECT_NEAR(rate, 0.0, 1e-12);
    }
    EXPECT_LT(plates.mass_times(accelerations(plates.states)).norm(), 1e-6) << mu;
  }
}

TEST(ExplicitContact, PenaltyPushesByDepthAndArea) {
  auto plates = meeting("enforcement = \"penalty\"\npenalty_pa_m = 1e9\n");
  plates.states[0].u.setConstant(1e-4);  // along n by 1e-4 m
  ExplicitContact contact(plates.problem.scene.contact_law(), plates.surface, clock_of_windows);
  contact.start(plates.states);
  const int lower = plates.node_at(0, {0.1, 0.0});
  EXPECT_NEAR(plates.states[0].a[2 * lower + 1], -1e9 * 0.1 * 1e-4 / 5.0, 1e-6);
}

test::ContactPlates uneven(const std::string& keys = "") {
  test::ContactPlates plates("all_explicit", keys);
  plates.use_three_rows();
  plates.set_velocity(0, {0.5, 3.0});
  plates.set_velocity(1, {-0.5, -1.0});
  plates.states[0].v[2 * plates.node_at(0, {0.0, 0.0}) + 1] = 6.0;
  plates.states[0].v[2 * plates.node_at(0, {0.2, 0.0}) + 1] = -6.0;  // moves away
  return plates;
}

/// g + dt dt/2 N M^-1 N^T r of all pairs.
std::vector<double> gaps_after_a_step(const test::ContactPlates& plates) {
  const std::vector<Eigen::VectorXd> u = {next_displacement(plates.states[0]), next_displacement(plates.states[1])};
  std::vector<double> gaps;
  for (const auto& pair : plates.surface.pairs)
    gaps.push_back(pair.gap([&](int part) -> const Eigen::VectorXd& { return u[static_cast<std::size_t>(part)]; }));
  return gaps;
}

TEST(SharedRowsExplicit, CloseWhatWouldOverlapAndPullNothing) {
  auto plates = uneven();
  ExplicitContact contact(plates.problem.scene.contact_law(), plates.surface, clock_of_windows);
  contact.start(plates.states);
  const auto gaps = gaps_after_a_step(plates);
  const auto forces = contact.state().forces;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE(forces[i].normal, 0.0);
    EXPECT_GE(gaps[i], -1e-17);
    EXPECT_NEAR(forces[i].normal * gaps[i], 0.0, 1e-10) << "forces of 1e7 N, gaps of 1e-6 m";
  }
  EXPECT_EQ(contact.pairs_closed(), 2);
  EXPECT_LT(plates.mass_times(accelerations(plates.states)).norm(), 1e-6) << "of forces of some 1e7 N";
  const auto report = contact.report(plates.states);
  EXPECT_GT(report.contact_iterations, 2);
  EXPECT_LE(report.contact_residual, 1e-12);
}

TEST(SharedRowsExplicit, HoldOrSlipByTheirCones) {
  for (const double mu : {0.05, 0.9}) {
    auto plates = uneven("friction_coefficient = " + std::to_string(mu) + "\n");
    ExplicitContact contact(plates.problem.scene.contact_law(), plates.surface, clock_of_windows);
    contact.start(plates.states);
    const auto forces = contact.state().forces;
    for (std::size_t i = 0; i < 3; ++i) {
      if (forces[i].state == solver::ContactState::open) continue;
      const auto& tangent = plates.surface.pairs[i].tangent;
      const double rate =
          tangent.times(velocity_of(plates.states)) + 0.5 * dt * tangent.times(accelerations(plates.states));
      if (forces[i].state == solver::ContactState::stick) {
        EXPECT_NEAR(rate, 0.0, 1e-11);
      } else {
        EXPECT_NEAR(std::abs(forces[i].tangential[0]), mu * forces[i].normal, 1e-12 * forces[i].normal);
        EXPECT_LT(forces[i].tangential[0] * rate, 0.0) << "against the slip";
      }
      EXPECT_EQ(forces[i].state, mu > 0.5 ? solver::ContactState::stick : solver::ContactState::slip);
    }
    EXPECT_LT(plates.mass_times(accelerations(plates.states)).norm(), 1e-6) << mu;
  }
}

}  // namespace
}  // namespace ricochet::explicit_solver
