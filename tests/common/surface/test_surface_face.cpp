#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

#include "common/surface/surface_face.hpp"

namespace ricochet::surface {
namespace {

/// A quadrilateral of a ball of radius 1 m that was a square with this middle and side on the top of a cube of half
/// size 1 m: those at the cube's corners are far from square.
SurfaceFace face_of_ball(double x, double y, double side) {
  SurfaceFace face{{0, 1, 2, 3}, {}, {}, {}};
  for (std::size_t k = 0; k < 4; ++k) {
    const double i = k == 0 || k == 3 ? -0.5 : 0.5, j = k < 2 ? -0.5 : 0.5;
    face.x[k] = face.node_normal[k] = Eigen::Vector3d(x + i * side, y + j * side, 1.0).normalized();
  }
  face.normal = (face.x[2] - face.x[0]).cross(face.x[3] - face.x[1]).normalized();
  return face;
}

// Rays that come from anywhere and see a face from anywhere, but its back: what they hit lies on them.
TEST(HitOf, IsOnTheRayOrNone) {
  int inside = 0, none = 0;
  for (const double at : {0.0, 0.25, 0.75}) {
    const SurfaceFace face = face_of_ball(at, 0.75, 0.5);
    const double size_m = (face.x[1] - face.x[0]).norm();
    for (int ray = 0; ray < 20000; ++ray) {
      const double polar = 1.5 * std::fmod(0.61803398875 * ray, 1.0), azimuth = 2.39996322973 * ray,
                   far = 3.0 * std::fmod(0.7548776662 * ray, 1.0), around = 1.2345 * ray;
      const Eigen::Vector3d across = face.normal.unitOrthogonal(), other = face.normal.cross(across),
                            along = -std::cos(polar) * face.normal +
                                    std::sin(polar) * (std::cos(azimuth) * across + std::sin(azimuth) * other),
                            from = face.x[0] + size_m * far * (std::cos(around) * across + std::sin(around) * other);
      const Hit hit = hit_of(from, along, face);
      none += std::isinf(hit.inside) ? 1 : 0;
      if (hit.inside < -0.05) continue;
      ++inside;
      const Eigen::Vector3d beside = place_at(face, hit.shape) - (from + hit.far_m * along);
      ASSERT_LT(beside.norm(), 2e-3 * size_m) << "ray " << ray << " of " << at << ", far " << hit.far_m;
      ASSERT_NEAR(hit.shape.sum(), 1.0, 1e-12);
    }
  }
  EXPECT_GT(inside, 3000);
  EXPECT_GT(none, 0) << "a face seen along itself";
}

}  // namespace
}  // namespace ricochet::surface
