#include "common/surface/plane_polygon.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <utility>

namespace ricochet::surface {
namespace {

/// Shape functions of a quadrilateral where its map has this value, by Newton's method.
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

}  // namespace

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

bool apart(const Polygon& a, const Polygon& b) {
  for (int c = 0; c < 2; ++c) {
    const auto less = [c](const Place& x, const Place& y) { return x[c] < y[c]; };
    const auto [low_a, high_a] = std::minmax_element(a.begin(), a.end(), less);
    const auto [low_b, high_b] = std::minmax_element(b.begin(), b.end(), less);
    if ((*high_a)[c] < (*low_b)[c] || (*high_b)[c] < (*low_a)[c]) return true;
  }
  return false;
}

double measure_of(const Polygon& piece) {
  double size = 0.0;
  integrate(piece, [&](const Place&, double weight) { size += weight; });
  return size;
}

}  // namespace ricochet::surface
