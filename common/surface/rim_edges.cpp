#include "common/surface/rim_edges.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace ricochet::surface {
namespace {

/// Sine of the angle between two lines from which on they cross.
constexpr double least_crossing = 0.05;
/// Cosine between the normals of two crossings at one place that are one.
constexpr double least_alike = 0.7;

/// Within an edge, its ends included; none beyond them.
std::optional<double> within_edge(double share) {
  if (!(share >= -same_place && share <= 1.0 + same_place)) return std::nullopt;
  return share < same_place ? 0.0 : share > 1.0 - same_place ? 1.0 : share;
}

bool at_end(const std::vector<fem::WeightedNode>& nodes) { return nodes[0].weight == 0.0 || nodes[1].weight == 0.0; }

/// The direction has parts along both outward directions of an edge that it is across.
bool between(const Eigen::Vector3d& n, const RimEdge& edge, double least) {
  const Eigen::Vector3d &a = edge.outward[0], &b = edge.outward[1];
  const double both = a.dot(b), square = 1.0 - both * both;
  return square > least * least && n.dot(a) - both * n.dot(b) > least * square &&
         n.dot(b) - both * n.dot(a) > least * square;
}

std::optional<EdgeCrossing> crossing_of(const RimEdge& first, const RimEdge& second, const Eigen::Vector3d& shift_m,
                                        double least_tilt) {
  const Eigen::Vector3d d = first.x[1] - first.x[0], e = second.x[1] - second.x[0], across = d.cross(e);
  const double lengths = d.norm() * e.norm(), square = across.squaredNorm();
  if (!(square > least_crossing * least_crossing * lengths * lengths)) return std::nullopt;
  Eigen::Vector3d n = across.normalized();
  if (n.dot(first.outward[0] + first.outward[1]) < 0.0) n = -n;
  if (!between(n, first, least_tilt) || !between(-n, second, least_tilt)) return std::nullopt;
  // first.x + s d + gap n = second.x + shift + t e
  const Eigen::Vector3d from = second.x[0] + shift_m - first.x[0];
  const auto s = within_edge(from.cross(e).dot(across) / square), t = within_edge(from.cross(d).dot(across) / square);
  if (!s || !t) return std::nullopt;
  return EdgeCrossing{{{first.node[0], 1.0 - *s}, {first.node[1], *s}},
                      {{second.node[0], 1.0 - *t}, {second.node[1], *t}},
                      0,
                      n,
                      from.dot(n),
                      0.25 * lengths};
}

Eigen::AlignedBox3d box_of(const RimEdge& edge) {
  return {edge.x[0].cwiseMin(edge.x[1]), edge.x[0].cwiseMax(edge.x[1])};
}

/// Away from a face in its plane, at its edge from one corner to the next.
Eigen::Vector3d away(const SurfaceFace& face, std::size_t from, std::size_t to) {
  return (face.x[to] - face.x[from]).cross(face.normal).normalized();
}

}  // namespace

RimEdges::RimEdges(const std::vector<SurfaceFace>& faces) : tree_({}) {
  struct Half {
    const SurfaceFace* face;
    std::size_t from, to;
  };
  std::map<std::pair<int, int>, std::vector<Half>> halves;
  for (const SurfaceFace& face : faces) {
    const std::size_t corners = face.node.size();
    if (corners < 3 || !has_edge(face)) continue;
    for (std::size_t i = 0; i < corners; ++i) {
      const std::size_t j = (i + 1) % corners;
      if (face.sharp[i] && face.sharp[j] && (face.held[i] & face.held[j]) == 0)
        halves[std::minmax(face.node[i], face.node[j])].push_back({&face, i, j});
    }
  }
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const auto& [nodes, of] : halves) {
    const auto [face, from, to] = of.front();
    if (of.size() > 2 || (of.size() == 2 && of[1].face->patch == face->patch)) continue;
    const auto [low, high] = face->node[from] < face->node[to] ? std::pair(from, to) : std::pair(to, from);
    RimEdge edge{{face->node[low], face->node[high]}, {face->x[low], face->x[high]}, {}, face->thickness_m};
    edge.outward = {face->normal, away(*face, from, to)};
    if (of.size() == 2) {
      if (of[1].face->normal.dot(edge.outward[1]) <= 0.0) continue;  // not convex
      edge.outward[1] = of[1].face->normal;
      edge.thickness_m = std::max(edge.thickness_m, of[1].face->thickness_m);
    }
    longest_m_ = std::max(longest_m_, (edge.x[1] - edge.x[0]).norm());
    boxes.push_back(box_of(edge));
    edges_.push_back(edge);
  }
  tree_ = BoxTree(std::move(boxes));
}

std::vector<EdgeCrossing> RimEdges::crossings(const RimEdges& first, const Eigen::Vector3d& shift_m,
                                              double least_tilt) const {
  std::vector<EdgeCrossing> crossings;
  const double reach_m = std::max(longest_m_, first.longest_m_);
  std::vector<std::size_t> near;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> at_ends;  // places and normals
  // Edges before and after a node cross there once, but for those of a corner, which stop what comes from two sides.
  const auto known = [&](const EdgeCrossing& found, const RimEdge& edge) {
    if (!at_end(found.first) && !at_end(found.second)) return false;
    const Eigen::Vector3d place = found.first[0].weight * edge.x[0] + found.first[1].weight * edge.x[1];
    const bool before = std::any_of(at_ends.begin(), at_ends.end(), [&](const auto& end) {
      return (end.first - place).norm() <= 4.0 * same_place * reach_m && end.second.dot(found.normal) > least_alike;
    });
    if (!before) at_ends.emplace_back(place, found.normal);
    return before;
  };
  for (std::size_t i = 0; i < first.edges_.size(); ++i) {
    const RimEdge& edge = first.edges_[i];
    const Eigen::AlignedBox3d box = box_of(edge).translated(-shift_m);
    near.clear();
    tree_.visit([&](const auto& other) { return box.squaredExteriorDistance(other) <= reach_m * reach_m; },
                [&](std::size_t j) { near.push_back(j); });
    std::sort(near.begin(), near.end());
    for (const std::size_t j : near) {
      auto crossing = crossing_of(edge, edges_[j], shift_m, least_tilt);
      if (!crossing || crossing->gap_m < -most_depth_m(std::min(edge.thickness_m, reach_m), edges_[j].thickness_m))
        continue;
      if (known(*crossing, edge)) continue;
      crossing->number = static_cast<int>(j * first.edges_.size() + i);
      crossings.push_back(std::move(*crossing));
    }
  }
  return crossings;
}

}  // namespace ricochet::surface
