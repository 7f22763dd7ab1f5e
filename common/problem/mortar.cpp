#include "common/problem/mortar.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace ricochet::scene {
namespace {

/// A face of which less lies opposite the other surface touches nothing: its dual basis would be round-off.
constexpr double least_share = 1e-4;

/// A place in the plane of a face; along an edge the second coordinate is 0.
using Place = Eigen::Vector2d;
using Polygon = std::vector<Place>;   ///< of two corners: a piece of a line
using ShapeValues = Eigen::Vector4d;  ///< 0 beyond the corners of a face

double cross(const Place& a, const Place& b) { return a[0] * b[1] - a[1] * b[0]; }

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

/// ShapeValues functions of a quadrilateral where its map has this value, by Newton's method.
ShapeValues quadrilateral_shape(const Polygon& corners, const Place& place) {
  static constexpr double xi_of[4] = {-1.0, 1.0, 1.0, -1.0}, eta_of[4] = {-1.0, -1.0, 1.0, 1.0};
  Place natural(0.0, 0.0);
  ShapeValues shape;
  for (int i = 0; i < 20; ++i) {
    Place found = -place;
    Eigen::Matrix2d slope = Eigen::Matrix2d::Zero();
    for (int k = 0; k < 4; ++k) {
      const double of_xi = 0.5 * (1.0 + xi_of[k] * natural[0]), of_eta = 0.5 * (1.0 + eta_of[k] * natural[1]);
      const Place& x = corners[static_cast<std::size_t>(k)];
      shape[k] = of_xi * of_eta;
      found += shape[k] * x;
      slope.col(0) += 0.5 * xi_of[k] * of_eta * x;
      slope.col(1) += 0.5 * eta_of[k] * of_xi * x;
    }
    const Place change = slope.inverse() * found;
    if (!(change.norm() > 1e-14)) break;
    natural -= change;
  }
  return shape;
}

ShapeValues shape_at(const Polygon& corners, const Place& place) {
  if (corners.size() == 4) return quadrilateral_shape(corners, place);
  const Place along = corners[1] - corners[0], from = place - corners[0];
  if (corners.size() == 2) {
    const double share = from[0] / along[0];
    return {1.0 - share, share, 0.0, 0.0};
  }
  const Place other = corners[2] - corners[0];
  const double whole = cross(along, other), second = cross(from, other) / whole, third = cross(along, from) / whole;
  return {1.0 - second - third, second, third, 0.0};
}

/// The part of `piece` within a convex polygon that is counter-clockwise (Sutherland, Hodgman 1974).
Polygon clipped(Polygon piece, const Polygon& by) {
  if (by.size() == 2) {
    const auto [low, high] = std::minmax(piece[0][0], piece[1][0]);
    return {{std::max(low, std::min(by[0][0], by[1][0])), 0.0}, {std::min(high, std::max(by[0][0], by[1][0])), 0.0}};
  }
  for (std::size_t i = 0; i < by.size() && !piece.empty(); ++i) {
    const Place &a = by[i], along = by[(i + 1) % by.size()] - a;
    Polygon inside;
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const Place &p = piece[k], &q = piece[(k + 1) % piece.size()];
      const double side_p = cross(along, p - a), side_q = cross(along, q - a);
      if (side_p >= 0.0) inside.push_back(p);
      if ((side_p > 0.0 && side_q < 0.0) || (side_p < 0.0 && side_q > 0.0))
        inside.push_back(p + side_p / (side_p - side_q) * (q - p));
    }
    piece = std::move(inside);
  }
  if (piece.size() < 3) piece.clear();  // a side of it lies along one of the other
  return piece;
}

/// Sums f(place, weight) over the Gauss points of a piece: exact for products of three linear functions on a line, for
/// those of two bilinear ones on a triangle (Dunavant 1985, degree 4).
template <class F>
void integrate(const Polygon& piece, const F& f) {
  if (piece.size() == 2) {
    const Place middle = 0.5 * (piece[0] + piece[1]), half = 0.5 * (piece[1] - piece[0]);
    for (const double sign : {-1.0, 1.0}) f(Place(middle + sign / std::sqrt(3.0) * half), half[0]);
    return;
  }
  static constexpr double near[2] = {0.445948490915965, 0.091576213509771},
                          weights[2] = {0.223381589678011, 0.109951743655322};
  for (std::size_t i = 2; i < piece.size(); ++i) {
    const Place &a = piece[0], &b = piece[i - 1], &c = piece[i];
    const double area = 0.5 * cross(b - a, c - a);
    if (!(area > 0.0)) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      const double far = 1.0 - 2.0 * near[k];
      f(Place(far * a + near[k] * (b + c)), weights[k] * area);
      f(Place(far * b + near[k] * (c + a)), weights[k] * area);
      f(Place(far * c + near[k] * (a + b)), weights[k] * area);
    }
  }
}

/// Length of a line, area of a polygon.
double measure_of(const Polygon& piece) {
  double size = 0.0;
  integrate(piece, [&](const Place&, double weight) { size += weight; });
  return size;
}

double measure_at(const SurfaceFace& face, const ShapeValues& shape) {
  return shape.dot(Eigen::Map<const Eigen::Vector4d>(face.measure.data()));
}

/// What lies opposite a face.
struct OppositePiece {
  Polygon corners, opposite;  ///< in the plane of the face
  const SurfaceFace* face;    ///< that lies opposite
};

/// integral phi_j and integral psi_j phi_k so far.
class RowSums {
 public:
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
    for (Eigen::Index j = 0; j < corners; ++j) area_[face.node[static_cast<std::size_t>(j)]] += d[j];
    for (const OppositePiece& piece : pieces) {
      integrate(piece.corners, [&](const Place& place, double weight) {
        const ShapeValues phi = shape_at(own, place), psi = dual * phi, other = shape_at(piece.opposite, place);
        weight *= measure_at(face, phi);
        for (Eigen::Index j = 0; j < corners; ++j) {
          auto& row = coupling_[face.node[static_cast<std::size_t>(j)]];
          for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(piece.opposite.size()); ++k)
            row[piece.face->node[static_cast<std::size_t>(k)]] += weight * psi[j] * other[k];
        }
      });
    }
  }
  [[nodiscard]] std::vector<MortarRow> rows() const {
    std::vector<MortarRow> rows;
    for (const auto& [node, area_m2] : area_) {
      MortarRow row{node, area_m2, {}};
      for (const auto& [other, value] : coupling_.at(node)) {
        if (std::abs(value) > 1e-14 * area_m2) row.opposite.push_back({other, value / area_m2});
      }
      rows.push_back(std::move(row));
    }
    return rows;
  }

 private:
  std::map<int, double> area_;
  std::map<int, std::map<int, double>> coupling_;
};

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -low;
};
Span extent_along(const SurfaceFace& face, const Eigen::Vector3d& direction) {
  Span extent;
  for (std::size_t i = 0; i < face.node.size(); ++i) {
    extent.low = std::min(extent.low, direction.dot(face.x[i]));
    extent.high = std::max(extent.high, direction.dot(face.x[i]));
  }
  return extent;
}

bool apart(const Polygon& a, const Polygon& b) {
  for (int c = 0; c < 2; ++c) {
    const auto less = [c](const Place& x, const Place& y) { return x[c] < y[c]; };
    const auto [low_a, high_a] = std::minmax_element(a.begin(), a.end(), less);
    const auto [low_b, high_b] = std::minmax_element(b.begin(), b.end(), less);
    if ((*high_a)[c] < (*low_b)[c] || (*high_b)[c] < (*low_a)[c]) return true;
  }
  return false;
}

}  // namespace

OppositeFaces::OppositeFaces(std::vector<SurfaceFace> faces, const std::optional<Eigen::Vector3d>& along,
                             const Eigen::Vector2d& period_m)
    : faces_(std::move(faces)), along_(along), period_m_(period_m) {
  const auto times = [](double period) { return period > 0.0 ? std::vector{0.0, -1.0, 1.0} : std::vector{0.0}; };
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const Span extent = along ? extent_along(faces_[i], *along) : Span{0.0, 0.0};
    longest_m_ = std::max(longest_m_, extent.high - extent.low);
    for (const double first : times(period_m[0])) {
      for (const double second : times(period_m[1])) {
        const Eigen::Vector3d moved_m(first * period_m[0], second * period_m[1], 0.0);
        images_.push_back({i, moved_m, extent.low + (along ? along->dot(moved_m) : 0.0)});
      }
    }
  }
  std::stable_sort(images_.begin(), images_.end(), [](const Image& x, const Image& y) { return x.low_m < y.low_m; });
}

std::vector<MortarRow> OppositeFaces::rows(const std::vector<SurfaceFace>& first, Eigen::Vector3d shift_m) const {
  for (Eigen::Index c = 0; c < 2; ++c) {
    if (period_m_[c] > 0.0) shift_m[c] -= period_m_[c] * std::round(shift_m[c] / period_m_[c]);
  }
  RowSums sums;
  std::vector<OppositePiece> pieces;
  for (const SurfaceFace& face : first) {
    const Plane plane(face);
    const Polygon own = plane.of(face, Eigen::Vector3d::Zero());
    const double size = measure_of(own), shifted_m = along_ ? along_->dot(shift_m) : 0.0;
    const Span extent = along_ ? extent_along(face, *along_) : Span{0.0, 0.0};
    auto image = std::lower_bound(images_.begin(), images_.end(), extent.low - shifted_m - longest_m_,
                                  [](const Image& x, double low_m) { return x.low_m < low_m; });
    pieces.clear();
    double covered = 0.0;
    for (; image != images_.end() && image->low_m <= extent.high - shifted_m; ++image) {
      const SurfaceFace& other = faces_[image->face];
      if (face.normal.dot(other.normal) >= 0.0) continue;
      Polygon opposite = plane.of(other, image->moved_m + shift_m);
      if (apart(own, opposite)) continue;
      Polygon piece = clipped({opposite.rbegin(), opposite.rend()}, own);  // seen from the face it is clockwise
      const double piece_size = piece.empty() ? 0.0 : measure_of(piece);
      if (!(piece_size > 0.0)) continue;
      covered += piece_size;
      pieces.push_back({std::move(piece), std::move(opposite), &other});
    }
    if (covered >= least_share * size) sums.add(face, own, pieces);
  }
  return sums.rows();
}

}  // namespace ricochet::scene
