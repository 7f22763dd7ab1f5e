#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "common/base/error.hpp"
#include "common/contact/contact_rows.hpp"
#include "common/contact/sliding_rows.hpp"
#include "tests/support/contact_blocks.hpp"
#include "tests/support/contact_plates.hpp"

namespace ricochet::solver {
namespace {

TEST(ContactRows, OfOppositeNodesMeasureTheGapAndTheSlip) {
  test::ContactPlates plates("all_implicit");
  ASSERT_EQ(plates.surface.pairs.size(), 3U);
  plates.states[0].u.setZero();
  for (int node = 0; node < plates.states[1].part.nodes(); ++node)
    plates.states[1].u.segment<2>(2 * node) << 2e-3, 5e-3;
  for (const auto& pair : plates.surface.pairs) {
    EXPECT_NEAR(pair.gap(displacement_of(plates.states)), 5e-3, 1e-18) << "n points from the lower plate to the upper";
    EXPECT_NEAR(pair.tangent.times(displacement_of(plates.states)), -2e-3, 1e-18) << "t = (-1, 0)";
    EXPECT_NEAR(pair.normal.of(Side::b, displacement_of(plates.states)), 5e-3, 1e-18);
    EXPECT_EQ(pair.normal.of(Side::a, displacement_of(plates.states)), 0.0);
    EXPECT_EQ(pair.normal.part_of(Side::a), 0);
    EXPECT_EQ(pair.normal.part_of(Side::b), 1);
  }
}

TEST(ContactRows, PushIsTheTransposeOfTimes) {
  test::ContactPlates plates("all_implicit");
  plates.use_one_row();
  const auto& row = plates.surface.pairs[0].normal;
  const auto velocity = [&](int part) -> Eigen::VectorXd& { return plates.states[static_cast<std::size_t>(part)].v; };
  row.push(3.0, plates.states, velocity);
  EXPECT_NEAR(row.times(velocity), 3.0 * row.inverse_mass(plates.states), 1e-14) << "N M^-1 N^T p";
  EXPECT_LT(plates.mass_times(velocity).norm(), 1e-15);
}

TEST(ContactRows, OfARigidPlaneBookItsImpulseToTheBody) {
  test::ContactPlates plates("all_implicit");
  plates.use_one_row();
  Pair pair = plates.surface.pairs[0];
  ContactImpulses impulses(1);
  book_impulse(pair, 2.0, {1.0, 0.0}, displacement_at(plates.states), plates.states, impulses);
  EXPECT_EQ(plates.states[0].totals.impulse_n_kg_m_s, 0.0) << "two bodies keep their momentum";
  for (auto* row : {&pair.normal, &pair.tangent})
    std::erase_if(row->entries, [](const RowEntry& e) { return e.side == Side::b; });
  book_impulse(pair, 2.0, {1.0, 0.0}, displacement_at(plates.states), plates.states, impulses);
  EXPECT_EQ(plates.states[0].totals.impulse_n_kg_m_s, -2.0);
  EXPECT_EQ(plates.states[0].totals.impulse_t_kg_m_s, -1.0);
  // at (0.1, 0): force (1, -2) on A, x F_y - y F_x = -0.2
  EXPECT_NEAR(plates.states[0].totals.angular_impulse_z_kg_m2_s, -0.2, 1e-16);
}

TEST(ContactRows, OfSolidsMeasureTheSlipAlongTangentAndBinormal) {
  test::ContactBlocks blocks("all_implicit");
  ASSERT_EQ(blocks.surface.pairs.size(), 9U);
  for (int node = 0; node < blocks.states[1].part.nodes(); ++node)
    blocks.states[1].u.segment<3>(3 * node) << 2e-3, 3e-3, 5e-3;
  for (const auto& pair : blocks.surface.pairs) {
    EXPECT_NEAR(pair.gap(displacement_of(blocks.states)), 5e-3, 1e-18);
    const Eigen::Vector2d slip = pair.slip(displacement_of(blocks.states));
    EXPECT_LT((slip - Eigen::Vector2d(2e-3, 3e-3)).norm(), 1e-18) << "t = x, n x t = y";
    const Eigen::Matrix2d inverse = pair.inverse_mass_along(blocks.states);
    EXPECT_EQ(inverse(0, 1), 0.0);
    EXPECT_EQ(inverse(0, 0), inverse(1, 1)) << "free nodes move alike in all directions";
  }
  Pair pair = blocks.surface.pairs[4];
  for (auto* row : {&pair.normal, &pair.tangent, &pair.binormal})
    std::erase_if(row->entries, [](const RowEntry& e) { return e.side == Side::b; });
  ContactImpulses impulses(1);
  book_impulse(pair, 2.0, {1.0, 3.0}, displacement_at(blocks.states), blocks.states, impulses);
  EXPECT_EQ(impulses[0].of_normal, Eigen::Vector3d(2.0, 0.0, 0.0));
  EXPECT_EQ(impulses[0].of_friction, Eigen::Vector3d(0.0, 1.0, 3.0));
  EXPECT_EQ(blocks.states[0].totals.impulse_n_kg_m_s, -2.0);
  EXPECT_EQ(blocks.states[0].totals.impulse_t_kg_m_s, -1.0);
  EXPECT_EQ(blocks.states[0].totals.impulse_b_kg_m_s, -3.0);
}

TEST(ContactRows, OfANodeThatIsHeldAlongATangentAreNotMovedThere) {
  const test::ContactBlocks blocks(
      "all_implicit", "friction_coefficient = 0.1\n",
      "support = [{ surface = \"start\", fixed = [\"x\"] }, { surface = \"end\", fixed = [\"x\"] }]\n");
  const Eigen::Matrix2d inverse = blocks.surface.pairs[0].inverse_mass_along(blocks.states);
  EXPECT_EQ(inverse(0, 0), 0.0) << "t = x";
  EXPECT_GT(inverse(1, 1), 0.0);
}

/// An edge slides from one face to the next, and a node between two pieces of its surface has a row for each.
TEST(ContactRows, WrittenAnewAreThoseOfTheSameNodeAndPieceOrEdge) {
  const auto row = [](int node, int patch) {
    Pair pair;
    pair.node_a = node;
    pair.patch = patch;
    return pair;
  };
  const std::vector<Pair> before = {row(4, 0), row(4, 1), row(7, -9)};
  EXPECT_THAT(same_pairs(before, {row(8, -9), row(4, 1), row(7, 0), row(4, 0)}), testing::ElementsAre(2, 1, -1, 0));
}

}  // namespace
}  // namespace ricochet::solver
