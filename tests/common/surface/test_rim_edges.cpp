#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/surface/rim_edges.hpp"

namespace ricochet::surface {
namespace {

constexpr double least_tilt = 1e-3, root = 0.5 * std::numbers::sqrt2;

/// The two upper sides of a roof whose ridge goes along y through the origin, or of a valley there, turned by `turn`.
std::vector<SurfaceFace> roof(const Eigen::Matrix3d& turn, double side = 1.0) {
  const Eigen::Vector3d first(0.0, -1.0, 0.0), second(0.0, 1.0, 0.0);  // nodes 0 and 1
  std::vector<SurfaceFace> faces = {
      {{2, 3, 1, 0}, {Eigen::Vector3d(1.0, -1.0, -side), Eigen::Vector3d(1.0, 1.0, -side), second, first}, {}, {}},
      {{4, 5, 0, 1}, {Eigen::Vector3d(-1.0, 1.0, -side), Eigen::Vector3d(-1.0, -1.0, -side), first, second}, {}, {}}};
  faces[0].normal = {root * side, 0.0, root};
  faces[1].normal = {-root * side, 0.0, root};
  for (SurfaceFace& face : faces) {
    face.sharp = {true, true, true, true};
    for (auto& place : face.x) place = turn * place;
    face.normal = turn * face.normal;
  }
  faces[1].patch = 1;
  return faces;
}

/// Upside down, its ridge along x.
Eigen::Matrix3d across() {
  return (Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

TEST(RimEdges, ThatCrossHaveTheGapBetweenTheirLines) {
  const RimEdges below(roof(Eigen::Matrix3d::Identity())), above(roof(across()));
  for (const double gap : {0.1, 0.0, -0.1}) {
    const auto crossings = above.crossings(below, {0.25, 0.5, gap}, least_tilt);
    ASSERT_EQ(crossings.size(), 1U);
    const EdgeCrossing& found = crossings.front();
    EXPECT_NEAR(found.gap_m, gap, 1e-15);
    EXPECT_NEAR((found.normal - Eigen::Vector3d::UnitZ()).norm(), 0.0, 1e-15);
    double along_y = 0.0, along_x = 0.0;  // places of nodes 0 and 1 of either ridge
    for (const auto& [node, share] : found.first) along_y += share * (node == 0 ? -1.0 : 1.0);
    for (const auto& [node, share] : found.second)
      along_x += share * (across() * Eigen::Vector3d(0.0, node == 0 ? -1.0 : 1.0, 0.0))[0];
    EXPECT_NEAR(along_y, 0.5, 1e-15);
    EXPECT_NEAR(along_x, -0.25, 1e-15);
  }
}

/// A ridge of two edges that meet at the origin.
std::vector<SurfaceFace> ridge_of_two(const Eigen::Matrix3d& turn) {
  std::vector<SurfaceFace> faces;
  for (const int half : {0, 1}) {
    for (SurfaceFace face : roof(Eigen::Matrix3d::Identity())) {
      for (int& node : face.node) node = node < 2 ? node + half : node + 10 * (half + 1);
      for (Eigen::Vector3d& place : face.x)
        place = turn * Eigen::Vector3d(place[0], 0.5 * place[1] + half - 0.5, place[2]);
      face.normal = turn * face.normal;
      faces.push_back(face);
    }
  }
  return faces;
}

/// However the directions of space round.
TEST(RimEdges, ThatCrossAtANodeCrossOnce) {
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d(std::sin(i), std::cos(3.0 * i), 0.3).normalized())
            .toRotationMatrix();
    const RimEdges below(ridge_of_two(turn)), above(ridge_of_two(turn * across()));
    const auto crossings = above.crossings(below, turn * Eigen::Vector3d(0.0, 0.0, 0.01), least_tilt);
    ASSERT_EQ(crossings.size(), 1U) << i;
    EXPECT_NEAR(crossings[0].gap_m, 0.01, 1e-14);
  }
}

/// The corner of a cube that points upwards, at the origin: node 0, its edges go down to nodes 1, 2 and 3.
std::vector<SurfaceFace> corner(const Eigen::Matrix3d& turn) {
  std::array<Eigen::Vector3d, 3> along;
  for (int i = 0; i < 3; ++i) {
    const double angle = (0.5 + 2.0 * i / 3.0) * std::numbers::pi;
    along[static_cast<std::size_t>(i)] =
        turn * Eigen::Vector3d(std::sqrt(2.0 / 3.0) * std::cos(angle), std::sqrt(2.0 / 3.0) * std::sin(angle),
                               -std::sqrt(1.0 / 3.0));
  }
  std::vector<SurfaceFace> faces;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Eigen::Vector3d &a = along[static_cast<std::size_t>(i)], &b = along[static_cast<std::size_t>(j)];
    SurfaceFace face{
        {0, 1 + i, 4 + i, 1 + j}, {Eigen::Vector3d(0.0, 0.0, 0.0), a, a + b, b}, {}, a.cross(b).normalized()};
    face.sharp = {true, true, true, true};
    face.patch = i;
    faces.push_back(face);
  }
  return faces;
}

/// A roof four times as steep.
std::vector<SurfaceFace> steep_roof(const Eigen::Matrix3d& turn) {
  auto faces = roof(Eigen::Matrix3d::Identity());
  for (SurfaceFace& face : faces) {
    for (auto& place : face.x) place = turn * place.cwiseProduct(Eigen::Vector3d(1.0, 1.0, 4.0));
    face.normal = (turn * face.normal.cwiseProduct(Eigen::Vector3d(4.0, 1.0, 1.0))).normalized();
  }
  return faces;
}

/// An edge over a corner touches it from both sides: a row for each, however the directions of space round.
TEST(RimEdges, OverACornerCrossTheEdgesOfBothItsSides) {
  const Eigen::Matrix3d beside = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()).toRotationMatrix() * across();
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d(std::sin(i), std::cos(3.0 * i), 0.3).normalized())
            .toRotationMatrix();
    const RimEdges below(corner(turn)), above(steep_roof(turn * beside));
    const auto crossings = above.crossings(below, Eigen::Vector3d::Zero(), least_tilt);
    ASSERT_EQ(crossings.size(), 2U) << i;
    EXPECT_LT(crossings[0].normal.dot(crossings[1].normal), 0.5);
  }
}

TEST(RimEdges, ThatLieBesideEachOtherOrAreParallelDoNotCross) {
  const RimEdges below(roof(Eigen::Matrix3d::Identity())), above(roof(across()));
  EXPECT_TRUE(above.crossings(below, {1.5, 0.0, 0.1}, least_tilt).empty());
  EXPECT_TRUE(above.crossings(below, {0.0, -1.5, 0.1}, least_tilt).empty());
  EXPECT_TRUE(above.crossings(below, {0.0, 0.0, -1.5}, least_tilt).empty()) << "deeper than half an edge";
  const Eigen::Matrix3d over = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_TRUE(RimEdges(roof(over)).crossings(below, {0.0, 0.0, 0.1}, least_tilt).empty()) << "parallel";
}

TEST(RimEdges, OfAValleyAndOfASmoothSurfaceAreNone) {
  const auto crosses_the_middle = [](const std::vector<SurfaceFace>& faces) {
    const auto crossings = RimEdges(roof(across())).crossings(RimEdges(faces), {0.25, 0.5, 0.1}, least_tilt);
    return std::any_of(crossings.begin(), crossings.end(),
                       [](const EdgeCrossing& found) { return found.first[0].node + found.first[1].node == 1; });
  };
  auto smooth = roof(Eigen::Matrix3d::Identity());
  EXPECT_TRUE(crosses_the_middle(smooth));
  for (SurfaceFace& face : smooth) face.patch = 0;
  EXPECT_FALSE(crosses_the_middle(smooth));
  EXPECT_FALSE(crosses_the_middle(roof(Eigen::Matrix3d::Identity(), -1.0)));
}

/// A plate's rim, of one face alone, and the ridge that lies on the plate: other rows have that.
TEST(RimEdges, ThatLieOnAFaceDoNotCross) {
  SurfaceFace plate{{0, 1, 2, 3},
                    {Eigen::Vector3d(-1.0, -1.0, 0.0), Eigen::Vector3d(1.0, -1.0, 0.0), Eigen::Vector3d(1.0, 1.0, 0.0),
                     Eigen::Vector3d(-1.0, 1.0, 0.0)},
                    {},
                    Eigen::Vector3d::UnitZ()};
  plate.sharp = {true, true, true, true};
  const RimEdges rim({plate}), ridge(roof(across()));
  EXPECT_TRUE(ridge.crossings(rim, {0.5, 0.5, 0.0}, least_tilt).empty());
  const Eigen::Matrix3d tilted = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() * across();
  const auto crossings = RimEdges(roof(tilted)).crossings(rim, {0.5, 0.5, 0.0}, least_tilt);
  ASSERT_EQ(crossings.size(), 1U) << "it goes down over the rim";
  EXPECT_NEAR(crossings.front().normal.dot(Eigen::Vector3d(std::sin(0.1), 0.0, std::cos(0.1))), 1.0, 1e-12);
}

}  // namespace
}  // namespace ricochet::surface
