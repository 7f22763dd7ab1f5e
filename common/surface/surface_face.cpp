#include "common/surface/surface_face.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>

namespace ricochet::surface {
namespace {

/// A face seen from its side may have no place on the ray. The search then ends beside the ray, by more than this share
/// of the face's size.
constexpr double missed = 1e-3;
/// The smooth surface stands off the face by little: few aims are enough, except where a large face is seen askew.
constexpr int least_aims = 4, most_aims = 20;

/// A face as it is seen along a direction, from a place.
struct View {
  Eigen::Vector3d from, first, second;

  View(const Eigen::Vector3d& place, const Eigen::Vector3d& along, bool edge)
      : from(place), first(edge ? Eigen::Vector3d(-along[1], along[0], 0.0) : along.unitOrthogonal()) {
    second = edge ? Eigen::Vector3d::Zero().eval() : along.cross(first).eval();
  }
  [[nodiscard]] Place of(const Eigen::Vector3d& x) const { return {first.dot(x - from), second.dot(x - from)}; }
};

}  // namespace

Eigen::Vector3d place_at(const SurfaceFace& face, const ShapeValues& shape) {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < face.node.size(); ++k) place += shape[static_cast<Eigen::Index>(k)] * face.x[k];
  double rise_m = 0.0;
  for (std::size_t k = 0; k < face.node.size(); ++k)
    rise_m += shape[static_cast<Eigen::Index>(k)] * (place - face.x[k]).dot(face.node_normal[k]);
  return place - 0.5 * rise_m * face.normal;
}

Eigen::Vector3d normal_at(const SurfaceFace& face, const ShapeValues& shape) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < face.node.size(); ++k)
    normal += shape[static_cast<Eigen::Index>(k)] * face.node_normal[k];
  return normal;
}

Hit hit_of(const Eigen::Vector3d& place, const Eigen::Vector3d& along, const SurfaceFace& face) {
  const View view(place, along, face.node.size() == 2);
  Polygon corners;
  for (std::size_t k = 0; k < face.node.size(); ++k) corners.push_back(view.of(face.x[k]));
  Place aim(0.0, 0.0);
  ShapeValues shape;
  Eigen::Vector3d found;
  const double size_m = (face.x[1] - face.x[0]).norm();
  double beside_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_aims && (i < least_aims || beside_m > missed * size_m); ++i) {
    shape = shape_at(corners, aim);
    found = place_at(face, shape);
    const Place off = view.of(found);
    beside_m = off.norm();
    aim -= off;
  }
  if (!(beside_m <= missed * size_m)) return {-std::numeric_limits<double>::infinity(), 0.0};
  const double* first = shape.data();
  return {std::min(0.0, *std::min_element(first, first + face.node.size())), along.dot(found - view.from), shape};
}

double most_depth_m(double thickness_m, double other_thickness_m) {
  return 0.5 * std::min(thickness_m, other_thickness_m);
}

bool has_edge(const SurfaceFace& face) {
  return std::find(face.sharp.begin(), face.sharp.end(), true) != face.sharp.end();
}

bool has_edges(const std::vector<SurfaceFace>& faces) { return std::any_of(faces.begin(), faces.end(), has_edge); }

}  // namespace ricochet::surface
