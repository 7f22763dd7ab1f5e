// Rows of edges, where bodies touch by these.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "common/surface/face_plane.hpp"
#include "common/surface/mortar.hpp"

namespace ricochet::surface {
namespace {

/// A face that is tilted by less against another lies on it, and its edge with it [rad].
constexpr double least_edge_tilt = 1e-3;

/// A share of the extent in a face's plane, for faces that are not quite flat.
constexpr double beyond_extent = 0.1;

Eigen::AlignedBox2d widened(const Eigen::AlignedBox2d& extent) {
  const double by_m = beyond_extent * extent.diagonal().norm();
  return {extent.min() - Eigen::Vector2d::Constant(by_m), extent.max() + Eigen::Vector2d::Constant(by_m)};
}

}  // namespace

void OppositeFaces::find_edges() {
  std::map<int, EdgeNode> edges;
  for (const SurfaceFace& face : faces_) {
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      if (!face.sharp[i]) continue;
      EdgeNode& edge = edges[face.node[i]];
      edge.node = face.node[i];
      edge.x = face.x[i];
      edge.thickness_m = std::max(edge.thickness_m, face.thickness_m);
      edge.normals.push_back(face.normal);
      const Polygon own = Plane(face).of(face, Eigen::Vector3d::Zero());
      edge.area_m2 += face.measure[i] * measure_of(own) / static_cast<double>(face.node.size());
    }
  }
  for (auto& [node, edge] : edges) edges_.push_back(std::move(edge));
  std::vector<Eigen::AlignedBox3d> places;
  for (const EdgeNode& edge : edges_) places.emplace_back(edge.x);
  edge_tree_ = BoxTree(std::move(places));
  rim_edges_ = RimEdges(faces_);
}

void OppositeFaces::add_crossing_rows(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                                      std::vector<MortarRow>& rows) const {
  if (rim_edges_.empty()) return;
  const int first_patch = -3 - edges_.back().node;  // below those of nodes at edges
  for (EdgeCrossing& crossing : rim_edges_.crossings(RimEdges(first), shift_m, least_edge_tilt))
    rows.push_back({.node = crossing.first[0].node,
                    .area_m2 = crossing.area_m2,
                    .opposite = std::move(crossing.second),
                    .patch = first_patch - crossing.number,
                    .normal = crossing.normal,
                    .gap_m = crossing.gap_m,
                    .own = std::move(crossing.first)});
}

void OppositeFaces::add_edge_rows(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                                  std::vector<MortarRow>& rows) const {
  if (edges_.empty()) return;
  std::set<int> with_rows;
  for (const MortarRow& row : rows) with_rows.insert(row.node);
  struct Opposite {
    Hit hit{0.0, std::numeric_limits<double>::infinity()};
    const SurfaceFace* face = nullptr;
  };
  std::vector<Opposite> nearest(edges_.size());
  for (const SurfaceFace& face : first) {
    const bool has_rows =
        std::all_of(face.node.begin(), face.node.end(), [&](int n) { return with_rows.count(n) > 0; });
    const Plane plane(face);
    const Eigen::AlignedBox2d extent = widened(extent_of(plane.of(face, Eigen::Vector3d::Zero())));
    const auto look_at = [&](std::size_t i) {
      const EdgeNode& edge = edges_[i];
      const auto facing = [&](double share) {
        return std::any_of(edge.normals.begin(), edge.normals.end(),
                           [&](const Eigen::Vector3d& normal) { return -normal.dot(face.normal) > share; });
      };
      const bool lies_on_it = facing(std::cos(least_edge_tilt));
      if ((has_rows && lies_on_it) || !facing(least_facing)) return;
      const Hit hit = hit_of(edge.x + shift_m, -face.normal, face);
      if (hit.inside < -same_place || hit.far_m < -most_depth_m(face.thickness_m, edge.thickness_m)) return;
      if (std::abs(hit.far_m) < std::abs(nearest[i].hit.far_m)) nearest[i] = {hit, &face};
    };
    edge_tree_.visit([&](const Eigen::AlignedBox3d& box) { return reaches(box, shift_m, plane, face, extent, 0.0); },
                     look_at);
  }
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const EdgeNode& edge = edges_[i];
    const auto& [hit, opposite] = nearest[i];
    if (opposite == nullptr) continue;
    MortarRow row{-1, edge.area_m2, {{edge.node, 1.0}}, -2 - edge.node, opposite->normal, hit.far_m};
    std::map<int, double> shares;
    for (std::size_t k = 0; k < opposite->node.size(); ++k)
      shares[opposite->node[k]] = hit.shape[static_cast<Eigen::Index>(k)];
    double largest = 0.0;
    for (const auto& [node, share] : shares) {
      row.own.push_back({node, share});
      if (share > largest) std::tie(largest, row.node) = std::pair(share, node);
    }
    rows.push_back(std::move(row));
  }
}

}  // namespace ricochet::surface
