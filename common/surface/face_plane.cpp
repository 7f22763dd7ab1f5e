#include "common/surface/face_plane.hpp"

#include <algorithm>
#include <cmath>

namespace ricochet::surface {

Polygon seen_along(const std::array<Eigen::Vector3d, 4>& directions, const SurfaceFace& face, const Plane& plane,
                   const Polygon& own, const SurfaceFace& other, const Eigen::Vector3d& moved_m) {
  Polygon feet = plane.of(other, moved_m);
  for (std::size_t k = 0; k < feet.size(); ++k) {
    const Eigen::Vector3d from = other.x[k] + moved_m - plane.origin;
    for (int i = 0; i < 4; ++i) {  // tilts are small
      const ShapeValues shape = shape_at(own, feet[k]);
      Eigen::Vector3d along = Eigen::Vector3d::Zero();
      for (std::size_t j = 0; j < own.size(); ++j)
        along += std::clamp(shape[static_cast<Eigen::Index>(j)], -1.0, 2.0) * directions[j];
      const double facing = along.dot(face.normal);
      if (!(facing > least_facing * along.norm())) break;
      const Eigen::Vector3d foot = from - from.dot(face.normal) / facing * along;
      feet[k] = {plane.first.dot(foot), plane.second.dot(foot)};
    }
  }
  return feet;
}

std::vector<Eigen::AlignedBox3d> boxes_of(const std::vector<SurfaceFace>& faces, const Eigen::Vector3d& moved_m) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const SurfaceFace& face : faces) {
    Eigen::AlignedBox3d& box = boxes.emplace_back();
    for (std::size_t i = 0; i < face.node.size(); ++i) box.extend(face.x[i] + moved_m);
  }
  return boxes;
}

bool reaches(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& moved_m, const Plane& plane,
             const SurfaceFace& face, const Eigen::AlignedBox2d& own, double tilt) {
  const Eigen::Vector3d middle = box.center() + moved_m - plane.origin, half = 0.5 * box.sizes();
  const double far_m = std::abs(face.normal.dot(middle)) + face.normal.cwiseAbs().dot(half);
  const auto outside = [&](const Eigen::Vector3d& direction, Eigen::Index c) {
    const double at = direction.dot(middle), size = direction.cwiseAbs().dot(half) + tilt * far_m;
    return at + size < own.min()[c] || at - size > own.max()[c];
  };
  return !outside(plane.first, 0) && (face.node.size() == 2 || !outside(plane.second, 1));
}

}  // namespace ricochet::surface
