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

/// No line along the face's normal through the place meets the face.
bool lies_beside(const Eigen::Vector3d& place, const SurfaceFace& face) {
  constexpr double margin = 1.1;  // of faces that are not quite flat
  double reach_m2 = 0.0;
  for (std::size_t i = 1; i < face.node.size(); ++i)
    reach_m2 = std::max(reach_m2, (face.x[i] - face.x[0]).squaredNorm());
  const Eigen::Vector3d from = place - face.x[0];
  const double along = from.dot(face.normal);
  return from.squaredNorm() - along * along > margin * margin * reach_m2;
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
  std::set<int> with_rows;
  for (const MortarRow& row : rows) with_rows.insert(row.node);
  std::vector<bool> has_rows;  // at all nodes of a face
  for (const SurfaceFace& face : first)
    has_rows.push_back(std::all_of(face.node.begin(), face.node.end(), [&](int n) { return with_rows.count(n) > 0; }));
  for (const EdgeNode& edge : edges_) {
    const Eigen::Vector3d place = edge.x + shift_m;
    const SurfaceFace* opposite = nullptr;
    Hit nearest{0.0, std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < first.size(); ++i) {
      const SurfaceFace& face = first[i];
      if (lies_beside(place, face)) continue;
      const auto lies_on_it = [&](const Eigen::Vector3d& normal) {
        return -normal.dot(face.normal) > std::cos(least_edge_tilt);
      };
      if (has_rows[i] && std::any_of(edge.normals.begin(), edge.normals.end(), lies_on_it)) continue;
      if (std::none_of(edge.normals.begin(), edge.normals.end(),
                       [&](const Eigen::Vector3d& normal) { return -normal.dot(face.normal) > least_facing; }))
        continue;
      const Hit hit = hit_of(place, -face.normal, face);
      if (hit.inside < -same_place || hit.far_m < -most_depth_m(face.thickness_m, edge.thickness_m)) continue;
      if (std::abs(hit.far_m) < std::abs(nearest.far_m)) std::tie(nearest, opposite) = std::pair(hit, &face);
    }
    if (opposite == nullptr) continue;
    MortarRow row{-1, edge.area_m2, {{edge.node, 1.0}}, -2 - edge.node, opposite->normal, nearest.far_m};
    std::map<int, double> shares;
    for (std::size_t k = 0; k < opposite->node.size(); ++k)
      shares[opposite->node[k]] = nearest.shape[static_cast<Eigen::Index>(k)];
    double largest = 0.0;
    for (const auto& [node, share] : shares) {
      row.own.push_back({node, share});
      if (share > largest) std::tie(largest, row.node) = std::pair(share, node);
    }
    rows.push_back(std::move(row));
  }
}

}  // namespace ricochet::surface
