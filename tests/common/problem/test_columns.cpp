#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/fem/mesh.hpp"
#include "common/problem/columns.hpp"
#include "common/problem/outline.hpp"

namespace ricochet::scene {
namespace {

/// Two blocks apart from each other: no convex surface, and edges of it above nodes of it.
TEST(Columns, KnowWhatLiesWithinOneOfTwoBlocks) {
  std::vector<Eigen::Vector3d> x;
  Columns::Triangles triangles;
  const Eigen::Vector3d size(0.2, 0.3, 0.4), aside(0.1, 0.05, 0.7);
  for (const Eigen::Vector3d& corner : {Eigen::Vector3d(0.0, 0.0, 0.0), aside}) {
    const fem::Mesh mesh = fem::block_mesh({0.0, 0.1, 0.2}, {0.0, 0.1, 0.2, 0.3}, {0.0, 0.1, 0.3, 0.4});
    const Outline outline = outline_of(mesh);
    const int first = static_cast<int>(x.size());
    for (const int node : outline.nodes) x.push_back(corner + mesh.position[fem::at(node)]);
    for (const auto& [i, j, k] : outline.triangles) triangles.push_back({first + i, first + j, first + k});
  }
  const Columns columns(triangles, x, {0.0, 0.0, 0.0}, aside + size, 0.1);
  const auto in_block = [&](const Eigen::Vector3d& place, double off_m) {
    return (place.array() > -off_m).all() && (place.array() < size.array() + off_m).all();
  };
  std::mt19937 random(3);
  std::uniform_int_distribution<int> step(-20, 140);
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d place = 0.01 * Eigen::Vector3d(step(random), step(random), step(random));
    if (in_block(place, 1e-4) != in_block(place, -1e-4) ||
        in_block(place - aside, 1e-4) != in_block(place - aside, -1e-4))
      continue;  // on the surface it may be either
    const bool expected = in_block(place, 0.0) || in_block(place - aside, 0.0);
    EXPECT_EQ(columns.within(place), expected) << place.transpose();
    inside += expected ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
}

}  // namespace
}  // namespace ricochet::scene
