#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/contact/contact_surface.hpp"
#include "tests/support/contact_plates.hpp"

namespace ricochet::solver {
namespace {

/// Moves the plates apart along the normal, by `at_x(x)` at a node of the upper one.
template <class AtX>
void open(test::ContactPlates& plates, Eigen::VectorXd BodyMotion::*values, const AtX& at_x) {
  auto& plate = plates.states[1];
  for (int node = 0; node < plate.part.nodes(); ++node)
    (plate.*values)[2 * node + 1] = at_x(plate.part.mesh.position[static_cast<std::size_t>(node)][0]);
}

TEST(ContactSurface, HasTheGapOfItsClosestPairAndTheRateOfItsFastest) {
  test::ContactPlates plates("all_implicit");
  open(plates, &BodyMotion::u, [](double x) { return 5e-3 - 0.02 * x; });
  open(plates, &BodyMotion::v, [](double x) { return -3.0 + 10.0 * x; });
  EXPECT_NEAR(plates.surface.gap_min(plates.states), 1e-3, 1e-17) << "at x = 0.2 m";
  EXPECT_NEAR(plates.surface.gap_rate_min(plates.states), -3.0, 1e-14) << "at x = 0";
}

TEST(ContactSurface, CountsItsInitialGap) {
  test::ContactPlates plates("all_implicit", "initial_gap_m = 2e-3\n");
  open(plates, &BodyMotion::u, [](double) { return -3e-3; });
  EXPECT_NEAR(plates.surface.gap_min(plates.states), -1e-3, 1e-17);
}

// The lower plate is squeezed by 1e-3 along y and kept from spreading along x, so that its end moves by -0.2 mm: its
// stress is lambda + 2 mu = 1.2 E for a Poisson ratio of 1/4.
TEST(ContactSurface, ReportsSumsOfItsPairsGapAndStress) {
  test::ContactPlates plates("all_implicit");
  auto& plate = plates.states[0];
  for (int node = 0; node < plate.part.nodes(); ++node)
    plate.u[2 * node + 1] = -1e-3 * (plate.part.mesh.position[static_cast<std::size_t>(node)][1] + 0.2);
  const std::vector<PairForce> forces = {{3.0, {1.0, 4.0}, ContactState::stick},
                                         {0.0, {0.0, 0.0}, ContactState::open},
                                         {5.0, {-2.5, 0.5}, ContactState::slip}};
  ContactRecord report = plates.surface.empty_record();
  ContactAccount account{.work_normal_j = -0.5,
                         .dissipated_friction_j = 0.25,
                         .impulses = {{{0.75, 4.0, 5.0}, {0.25, 2.0, 3.0}}},
                         .iterations = 4,
                         .largest_residual = 1e-7,
                         .unconverged = 2};
  plates.surface.report(plates.states, forces, account, report);
  EXPECT_EQ(report.energy_contact_j, -0.5);
  EXPECT_EQ(report.energy_friction_j, 0.25);
  EXPECT_EQ(report.contact_iterations, 4);
  EXPECT_EQ(report.contact_residual, 1e-7);
  EXPECT_EQ(report.contact_unconverged, 2);
  EXPECT_EQ(report.contact_force_n, 8.0);
  EXPECT_EQ(report.friction_force_n, -1.5);
  EXPECT_EQ(report.friction_force_b_n, 4.5);
  EXPECT_EQ(report.contact_impulse_n_s, 1.0);
  EXPECT_EQ(report.friction_impulse_n_s, 2.0);
  EXPECT_EQ(report.friction_impulse_b_n_s, 3.0);
  EXPECT_EQ(report.normal_impulse_t_n_s, 4.0);
  EXPECT_EQ(report.normal_impulse_b_n_s, 5.0);
  EXPECT_EQ(report.normal_force_t_n, 0.0) << "flat";
  EXPECT_TRUE(report.contacts.empty()) << "there is but one";
  EXPECT_EQ(report.pairs_stick, 1);
  EXPECT_EQ(report.pairs_slip, 1);
  EXPECT_EQ(report.pairs_open, 1);
  EXPECT_NEAR(report.contact_pressure_mean_pa, 80.0, 1e-13) << "8 N on the ends' 2 x 0.05 m x 1 m";
  EXPECT_NEAR(report.contact_pressure_max_pa, 100.0, 1e-13);
  EXPECT_EQ(report.contact_radius_m, 0.0) << "plane strain has none";
  EXPECT_NEAR(report.gap_min_m, 0.2e-3, 1e-18);
  EXPECT_NEAR(report.principal_stress_mean_pa, 1.2e6, 1e-4);
  account.impulses = plates.surface.no_impulses();
  plates.surface.report(plates.states, {forces[0], forces[0], forces[1]}, account, report);
  EXPECT_EQ(report.contact_iterations, 0) << "since the last report";
  EXPECT_EQ(report.contact_residual, 0.0) << "since the last report";
  EXPECT_EQ(report.contact_unconverged, 2) << "of the whole run";
  EXPECT_EQ(report.pairs_stick, 2);
  EXPECT_EQ(report.pairs_slip, 0);
  EXPECT_EQ(report.pairs_open, 1);
}

// The same pairs as if the last of them were of another contact.
TEST(ContactSurface, ReportsEachOfSeveralContacts) {
  test::ContactPlates plates("all_implicit");
  plates.surface.contact_keys = {"contact.one", "contact.two", "contact.without_pairs"};
  plates.surface.pairs[2].contact = 1;
  open(plates, &BodyMotion::u, [](double x) { return 1e-3 + 1e-2 * x; });
  const std::vector<PairForce> forces = {{3.0, {1.0, 4.0}, ContactState::stick},
                                         {0.0, {0.0, 0.0}, ContactState::open},
                                         {5.0, {-2.5, 0.5}, ContactState::slip}};
  ContactRecord report = plates.surface.empty_record();
  ContactAccount account{.impulses = {{{0.0, 0.0, 0.0}, {1.0, 2.0, 3.0}}, {{0.0, 0.0, 0.0}, {4.0, 5.0, 6.0}}, {}}};
  plates.surface.report(plates.states, forces, account, report);
  ASSERT_EQ(report.contacts.size(), 3U);
  const auto &one = report.contacts[0], &two = report.contacts[1], &none = report.contacts[2];
  EXPECT_EQ(one.contact_force_n, 3.0);
  EXPECT_EQ(two.friction_force_n, -2.5);
  EXPECT_EQ(two.friction_force_b_n, 0.5);
  EXPECT_EQ(one.pairs_stick + one.pairs_open, 2.0);
  EXPECT_EQ(two.pairs_slip, 1.0);
  double area = 0.0;
  for (const auto& pair : plates.surface.pairs) area += pair.contact == 1 ? pair.area_m2 : 0.0;
  EXPECT_EQ(two.contact_pressure_mean_pa, 5.0 / area);
  EXPECT_EQ(std::min(one.gap_min_m, two.gap_min_m), report.gap_min_m);
  EXPECT_NE(one.gap_min_m, two.gap_min_m);
  EXPECT_EQ(two.contact_impulse_n_s, 4.0);
  EXPECT_EQ(report.contact_impulse_n_s, 5.0);
  EXPECT_EQ(report.friction_impulse_b_n_s, 9.0);
  EXPECT_EQ(none.gap_min_m, std::numeric_limits<double>::max()) << "no pair";
  EXPECT_EQ(none.contact_pressure_mean_pa, 0.0);
}

/// The normal of the first pair is turned by 30 degrees from that of its contact: what its forces are along the tangent
/// of the contact is not all friction.
TEST(ContactSurface, TellsTheTangentialPartOfNormalForcesFromFriction) {
  test::ContactPlates plates("all_implicit");
  Turn& turn = plates.surface.pairs[0].to_contact;
  turn.turned = true;
  const double c = std::cos(M_PI / 6.0), s = std::sin(M_PI / 6.0);
  turn.matrix << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
  const std::vector<PairForce> forces = {
      {3.0, {1.0, 4.0}, ContactState::slip}, {5.0, {2.0, 0.0}, ContactState::slip}, {}};
  ContactRecord report = plates.surface.empty_record();
  ContactAccount account{.impulses = plates.surface.no_impulses()};
  for (std::size_t i = 0; i < forces.size(); ++i)
    book_impulse(plates.surface.pairs[i], forces[i].normal, forces[i].tangential, displacement_at(plates.states),
                 plates.states, account.impulses);
  plates.surface.report(plates.states, forces, account, report);
  EXPECT_NEAR(report.contact_force_n, 3.0 * c - s + 5.0, 1e-15);
  EXPECT_NEAR(report.friction_force_n, c + 2.0, 1e-15);
  EXPECT_NEAR(report.normal_force_t_n, 3.0 * s, 1e-15);
  EXPECT_NEAR(report.friction_force_b_n, 4.0, 1e-15);
  EXPECT_EQ(report.normal_force_b_n, 0.0);
  EXPECT_EQ(report.contact_impulse_n_s, report.contact_force_n) << "of a window of 1 s";
  EXPECT_EQ(report.friction_impulse_n_s, report.friction_force_n);
  EXPECT_EQ(report.normal_impulse_t_n_s, report.normal_force_t_n);
}

/// Status of two plates whose gap is given window by window from the first on, in windows of 0.5 s; a pair is closed
/// while it is 0.
participant::ContactStatus after(const std::vector<double>& gaps, double until_separated_plus_s) {
  test::ContactPlates plates("all_implicit");
  participant::Setup setup;
  setup.clock = 0.5;
  setup.until_separated_plus_s = until_separated_plus_s;
  SeparationWatch separation(1);
  participant::ContactStatus status;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    open(plates, &BodyMotion::u, [&](double) { return gaps[i]; });
    open(plates, &BodyMotion::v, [&](double) { return 2.0; });
    status = contact_status(plates.surface, plates.states, gaps[i] == 0.0 ? 3 : 0, static_cast<std::int64_t>(i + 1),
                            setup, separation);
  }
  return status;
}

TEST(ContactStatus, SaysWhatTheGapsAreAndWhenTheyOpened) {
  auto status = after({0.0}, -1.0);
  EXPECT_EQ(status.pairs_closed, 3);
  EXPECT_FALSE(status.separated);
  status = after({0.0, 0.125, 0.25}, -1.0);
  EXPECT_EQ(status.pairs_closed, 0);
  EXPECT_EQ(status.gap_min_m, 0.25);
  EXPECT_EQ(status.gap_rate_min_m_s, 2.0);
  EXPECT_TRUE(status.separated);
  EXPECT_EQ(status.separation_time_s, 1.0) << "the end of the second window";
}

TEST(ContactStatus, IsFinishedTheStatedTimeAfterSeparation) {
  EXPECT_FALSE(after({0.0, 0.1, 0.2, 0.3}, 1.5).finished) << "2 s, 1 s after it";
  EXPECT_TRUE(after({0.0, 0.1, 0.2, 0.3, 0.4}, 1.5).finished) << "2.5 s";
  EXPECT_TRUE(after({0.0, 0.1}, 0.0).finished) << "at once";
}

TEST(ContactStatus, IsNotFinishedWithoutThatTimeWithoutAContactOrInTheNextOne) {
  EXPECT_FALSE(after({0.0, 0.1, 0.2, 0.3, 0.4}, -1.0).finished);
  EXPECT_FALSE(after({0.1, 0.2, 0.3, 0.4, 0.5}, 0.0).finished) << "the plates have not met";
  EXPECT_FALSE(after({0.0, 0.1, 0.2, 0.3, 0.0}, 1.5).finished) << "they have met again";
}

}  // namespace
}  // namespace ricochet::solver
