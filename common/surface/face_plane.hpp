#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "common/surface/surface_face.hpp"

namespace ricochet::surface {

/// Faces that are seen from a place so much from the side are not what lies opposite.
constexpr double least_facing = 0.1;

/// Coordinates in the plane of a face.
struct Plane {
  Eigen::Vector3d origin, first, second;

  explicit Plane(const SurfaceFace& face) : origin(face.x[0]), first(face.x[1] - face.x[0]) {
    first = (first - first.dot(face.normal) * face.normal).normalized();
    second = face.node.size() == 2 ? Eigen::Vector3d::Zero().eval() : face.normal.cross(first).eval();
  }
  [[nodiscard]] Polygon of(const SurfaceFace& face, const Eigen::Vector3d& moved_m) const {
    Polygon polygon;
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      const Eigen::Vector3d x = face.x[i] + moved_m - origin;
      polygon.emplace_back(first.dot(x), second.dot(x));
    }
    return polygon;
  }
};

/// Where the corners of a face lie in the plane of another, whose corners there are `own`: on the lines along that
/// one's directions, which change between its corners as its shape functions do.
[[nodiscard]] Polygon seen_along(const std::array<Eigen::Vector3d, 4>& directions, const SurfaceFace& face,
                                 const Plane& plane, const Polygon& own, const SurfaceFace& other,
                                 const Eigen::Vector3d& moved_m);

/// Per face of every image of it a box.
[[nodiscard]] std::vector<Eigen::AlignedBox3d> boxes_of(const std::vector<SurfaceFace>& faces,
                                                        const Eigen::Vector3d& moved_m);

/// A box that has moved may have a part that lies opposite a face, whose corners are `own` in its plane, along
/// directions that differ from its normal by no more than `tilt`.
[[nodiscard]] bool reaches(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& moved_m, const Plane& plane,
                           const SurfaceFace& face, const Eigen::AlignedBox2d& own, double tilt);

}  // namespace ricochet::surface
