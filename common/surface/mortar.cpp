#include "common/surface/mortar.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "common/surface/face_plane.hpp"

namespace ricochet::surface {
namespace {

/// A face of which less lies opposite the other surface touches nothing: its dual basis would be round-off.
constexpr double least_share = 1e-4;
/// Smooth surfaces that touch have normals that differ by less [rad].
constexpr double most_tilt = 0.35;
/// Directions that differ by less are one.
constexpr double same_direction = 1e-9;

double measure_at(const SurfaceFace& face, const ShapeValues& shape) {
  return shape.dot(Eigen::Map<const Eigen::Vector4d>(face.measure.data()));
}

/// All that lies opposite a face.
struct OppositePiece {
  Polygon corners, opposite;  ///< in the plane of the face
  const SurfaceFace* face;    ///< that lies opposite
  Eigen::Vector3d moved_m;
};

bool back_to_back(const SurfaceFace& face, const SurfaceFace& other, const Eigen::Vector3d& moved_m) {
  return face.normal.dot(other.x[0] + moved_m - face.x[0]) < -most_depth_m(face.thickness_m, other.thickness_m);
}

std::array<Eigen::Vector3d, 4> own_normals(const SurfaceFace& face) { return face.node_normal; }

/// A hit so far beside a face is none, in shares of it; where bodies touch by edges, beside one at the rim.
constexpr double beside = 0.05, beside_rim = 1e-3;
}  // namespace

/// integral phi_j and integral psi_j phi_k so far.
class OppositeFaces::RowSums {
 public:
  RowSums(bool edges_touch, bool overlaps) : edges_touch_(edges_touch), overlaps_(overlaps) {}

  void add(const SurfaceFace& face, const Polygon& own, const std::vector<OppositePiece>& pieces) {
    const auto corners = static_cast<Eigen::Index>(own.size());
    ShapeValues d = ShapeValues::Zero();
    Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
    for (Eigen::Index beyond = corners; beyond < 4; ++beyond) m(beyond, beyond) = 1.0;
    for (const OppositePiece& piece : pieces) {
      integrate(piece.corners, [&](const Place& place, double weight) {
        const ShapeValues phi = shape_at(own, place);
        weight *= measure_at(face, phi);
        d += weight * phi;
        m += weight * phi * phi.transpose();
      });
    }
    const Eigen::Matrix4d dual = d.asDiagonal() * m.inverse();
    std::array<Sum*, 4> sums{};
    for (Eigen::Index j = 0; j < corners; ++j) {
      const auto at = static_cast<std::size_t>(j);
      Sum& sum = *(sums[at] = &sums_[key(face, at)]);
      sum.area_m2 += d[j];
      sum.place = face.x[at];
      sum.normal = face.node_normal[at];
      sum.held = face.held[at];
      sum.sharp = face.sharp[at];
      for (const OppositePiece& piece : pieces)
        if (!far_from(piece.opposite, own[at])) sum.near.push_back({piece.face, piece.moved_m});
    }
    for (const OppositePiece& piece : pieces) {
      integrate(piece.corners, [&](const Place& place, double weight) {
        const ShapeValues phi = shape_at(own, place), psi = dual * phi, other = shape_at(piece.opposite, place);
        weight *= measure_at(face, phi);
        const Eigen::Vector3d apart = place_at(*piece.face, other) + piece.moved_m - place_at(face, phi),
                              normal = normal_at(*piece.face, other);
        for (Eigen::Index j = 0; j < corners; ++j) {
          Sum& sum = *sums[static_cast<std::size_t>(j)];
          sum.apart += weight * phi[j] * apart;
          sum.other_normal += weight * phi[j] * normal;
          for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(piece.opposite.size()); ++k) {
            const int node = piece.face->node[static_cast<std::size_t>(k)];
            sum.coupling[node] += weight * psi[j] * other[k];
            if (overlaps_) sum.overlap[node] += weight * phi[j] * other[k];
          }
        }
      });
    }
  }
  /// At the nodes of a face of the first surface the normals of that to which both deform.
  [[nodiscard]] std::array<Eigen::Vector3d, 4> normals(const SurfaceFace& face, double first_share) const {
    std::array<Eigen::Vector3d, 4> normals = face.node_normal;
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      const auto found = sums_.find(key(face, i));
      if (found != sums_.end()) normals[i] = normal_of(found->second, first_share);
    }
    return normals;
  }
  [[nodiscard]] std::vector<MortarRow> rows(double first_share) const {
    std::vector<MortarRow> rows;
    for (const auto& [place, sum] : sums_) {
      const Eigen::Vector3d normal = normal_of(sum, first_share);
      const OppositePlace opposite = opposite_of(sum, normal);
      if (edges_touch_ && opposite.face == nullptr) continue;
      MortarRow row{place.second, sum.area_m2, {}, place.first, normal, opposite.gap_m};
      std::map<int, double> shares;
      if (edges_touch_ && sum.sharp && opposite.face != nullptr) {
        for (std::size_t k = 0; k < opposite.face->node.size(); ++k)
          shares[opposite.face->node[k]] = opposite.shape[static_cast<Eigen::Index>(k)];
      } else {
        for (const auto& [other, value] : sum.coupling) shares[other] = value / sum.area_m2;
      }
      for (const auto& [other, share] : shares)
        if (std::abs(share) > 1e-14) row.opposite.push_back({other, share});
      for (const auto& [other, value] : sum.overlap)
        if (value > 1e-14 * sum.area_m2) row.overlap.push_back({other, value / sum.area_m2});
      rows.push_back(std::move(row));
    }
    return rows;
  }

 private:
  struct Opposite {
    const SurfaceFace* face;
    Eigen::Vector3d moved_m;
  };
  struct Sum {
    double area_m2 = 0.0;
    Eigen::Vector3d place{0.0, 0.0, 0.0}, normal{0.0, 0.0, 0.0};
    unsigned held = 0;
    bool sharp = false;
    std::map<int, double> coupling, overlap;
    Eigen::Vector3d apart{0.0, 0.0, 0.0}, other_normal{0.0, 0.0, 0.0};  ///< integrals with phi_j
    std::vector<Opposite> near;
  };

  [[nodiscard]] std::pair<int, int> key(const SurfaceFace& face, std::size_t node) const {
    return {edges_touch_ && face.sharp[node] ? -1 : face.patch, face.node[node]};
  }
  /// Beyond a plane of symmetry the other surface goes on as on this side of it.
  [[nodiscard]] Eigen::Vector3d normal_of(const Sum& sum, double first_share) const {
    Eigen::Vector3d other = sum.other_normal;
    if (edges_touch_ && sum.sharp) return -other.normalized();
    if (edges_touch_ && -other.normalized().dot(sum.normal) < std::cos(most_tilt)) return sum.normal;
    for (Eigen::Index c = 0; c < 3; ++c)
      if ((sum.held >> c & 1U) != 0) other[c] = 0.0;
    return (first_share * sum.normal - (1.0 - first_share) * other.normalized()).normalized();
  }
  /// The place that the line along the normal of a node meets; `face` is null where it meets nothing.
  struct OppositePlace {
    double gap_m;
    const SurfaceFace* face = nullptr;
    ShapeValues shape = ShapeValues::Zero();
  };
  [[nodiscard]] OppositePlace opposite_of(const Sum& sum, const Eigen::Vector3d& normal) const {
    Hit best{-std::numeric_limits<double>::infinity(), 0.0};
    const SurfaceFace* face = nullptr;
    for (const Opposite& near : sum.near) {
      if (!(near.face->normal.dot(normal) < -least_facing)) continue;
      const Hit hit = hit_of(sum.place - near.moved_m, normal, *near.face);
      if (hit.inside > best.inside || (hit.inside == best.inside && std::abs(hit.far_m) < std::abs(best.far_m)))
        std::tie(best, face) = std::pair(hit, near.face);
    }
    const bool rim = edges_touch_ && face != nullptr && has_edge(*face);
    if (best.inside >= (rim ? -beside_rim : -beside)) return {best.far_m, face, best.shape};
    return {sum.apart.dot(normal) / sum.area_m2};
  }
  /// By more than the polygon's size.
  static bool far_from(const Polygon& polygon, const Place& place) {
    return extent_of(polygon).exteriorDistance(place) > extent_of(polygon).diagonal().norm();
  }

  bool edges_touch_, overlaps_;
  std::map<std::pair<int, int>, Sum> sums_;  ///< by patch and node
};

OppositeFaces::OppositeFaces(std::vector<SurfaceFace> faces, const Eigen::Vector2d& period_m)
    : faces_(std::move(faces)), edge_tree_({}), period_m_(period_m), tree_({}) {
  const auto times = [](double period) { return period > 0.0 ? std::vector{0.0, -1.0, 1.0} : std::vector{0.0}; };
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const double first : times(period_m[0])) {
    for (const double second : times(period_m[1])) {
      const Eigen::Vector3d moved_m(first * period_m[0], second * period_m[1], 0.0);
      const auto moved = boxes_of(faces_, moved_m);
      boxes.insert(boxes.end(), moved.begin(), moved.end());
      for (std::size_t i = 0; i < faces_.size(); ++i) images_.push_back({i, moved_m});
    }
  }
  tree_ = BoxTree(std::move(boxes));
  find_edges();
}

Eigen::Vector3d OppositeFaces::within_period(Eigen::Vector3d shift_m) const {
  for (Eigen::Index c = 0; c < 2; ++c) {
    if (period_m_[c] > 0.0) shift_m[c] -= period_m_[c] * std::round(shift_m[c] / period_m_[c]);
  }
  return shift_m;
}

OppositeFaces::RowSums OppositeFaces::sums(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                                           const Normals& normals_of, bool edges_touch, bool overlaps) const {
  RowSums sums(edges_touch, overlaps);
  std::vector<OppositePiece> pieces;
  std::vector<std::size_t> near;
  for (const SurfaceFace& face : first) {
    const Plane plane(face);
    const Polygon own = plane.of(face, Eigen::Vector3d::Zero());
    const std::array<Eigen::Vector3d, 4> directions = normals_of(face);
    double tilt = 0.0;
    for (std::size_t i = 0; i < own.size(); ++i) tilt = std::max(tilt, (directions[i] - face.normal).norm());
    const Eigen::AlignedBox2d extent = extent_of(own);
    near.clear();
    tree_.visit([&](const Eigen::AlignedBox3d& box) { return reaches(box, shift_m, plane, face, extent, 2.0 * tilt); },
                [&](std::size_t image) { near.push_back(image); });
    std::sort(near.begin(), near.end());
    pieces.clear();
    double covered = 0.0;
    for (const std::size_t image : near) {
      const SurfaceFace& other = faces_[images_[image].face];
      if (face.normal.dot(other.normal) >= -least_facing) continue;
      const Eigen::Vector3d moved_m = images_[image].moved_m + shift_m;
      if (back_to_back(face, other, moved_m)) continue;
      Polygon opposite =
          tilt > same_direction ? seen_along(directions, face, plane, own, other, moved_m) : plane.of(other, moved_m);
      if (apart(own, opposite)) continue;
      Polygon piece = clipped({opposite.rbegin(), opposite.rend()}, own);  // seen from the face it is clockwise
      const double piece_size = piece.empty() ? 0.0 : measure_of(piece);
      if (!(piece_size > 0.0)) continue;
      covered += piece_size;
      pieces.push_back({std::move(piece), std::move(opposite), &other, moved_m});
    }
    if (covered >= least_share * measure_of(own)) sums.add(face, own, pieces);
  }
  return sums;
}

std::vector<MortarRow> OppositeFaces::rows(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m,
                                           double first_share, bool edges_touch) const {
  const Eigen::Vector3d shift = within_period(shift_m);
  const RowSums by_own = sums(first, shift, own_normals, edges_touch);
  const auto between = [&](const SurfaceFace& face) { return by_own.normals(face, first_share); };
  const bool same = std::all_of(first.begin(), first.end(), [&](const SurfaceFace& face) {
    return std::equal(face.node_normal.begin(), face.node_normal.end(), between(face).begin(),
                      [](const auto& x, const auto& y) { return (x - y).norm() <= same_direction; });
  });
  std::vector<MortarRow> rows = (same ? by_own : sums(first, shift, between, edges_touch)).rows(first_share);
  if (edges_touch) {
    add_edge_rows(first, shift, rows);
    add_crossing_rows(first, shift, rows);
  }
  return rows;
}

std::vector<MortarRow> OppositeFaces::rows_of_tie(const std::vector<SurfaceFace>& first) const {
  return sums(first, Eigen::Vector3d::Zero(), own_normals, false, true).rows(0.5);
}

double OppositeFaces::apart_m(const std::vector<SurfaceFace>& first, const Eigen::Vector3d& shift_m) const {
  const Eigen::Vector3d shift = within_period(shift_m);
  double square = std::numeric_limits<double>::infinity(), longest_m = 0.0;
  for (const SurfaceFace& face : first) {
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      longest_m = std::max(longest_m, (face.x[(i + 1) % face.node.size()] - face.x[i]).norm());
      const Eigen::Vector3d place = face.x[i] - shift;
      double of_box = 0.0;  // of the one asked for last
      tree_.visit(
          [&](const Eigen::AlignedBox3d& box) { return (of_box = box.squaredExteriorDistance(place)) < square; },
          [&](std::size_t) { square = of_box; });
    }
  }
  return std::sqrt(square) - longest_m;
}

}  // namespace ricochet::surface
