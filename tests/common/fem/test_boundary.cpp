#include <gtest/gtest.h>

#include <algorithm>

#include "common/fem/boundary.hpp"

namespace ricochet::fem {
namespace {

TEST(BoundaryFaces, AreThoseOfTheSixSidesWithTheirElements) {
  const Mesh mesh = block_mesh({0.0, 1.0, 2.0}, {0.0, 1.0, 2.0, 3.0}, {0.0, 1.0, 2.0, 3.0, 4.0});
  const auto faces = boundary_faces(mesh);
  EXPECT_EQ(faces.size(), 2U * (2 * 3 + 2 * 4 + 3 * 4));
  std::size_t named = 0;
  for (const auto& [name, surface] : mesh.surfaces) {
    named += surface.size();
    for (const Face& face : surface)
      EXPECT_EQ(std::ranges::count_if(faces, [&](const BoundaryFace& own) { return own.face == face; }), 1) << name;
  }
  EXPECT_EQ(named, faces.size());
  for (const auto& [face, number] : faces) {
    const Element& nodes = mesh.elements[at(number)];
    for (const int node : face) EXPECT_NE(std::find(nodes.begin(), nodes.end(), node), nodes.end());
  }
  EXPECT_TRUE(std::is_sorted(faces.begin(), faces.end(), [](const BoundaryFace& one, const BoundaryFace& other) {
    return sorted(one.face) < sorted(other.face);
  }));
}

}  // namespace
}  // namespace ricochet::fem
