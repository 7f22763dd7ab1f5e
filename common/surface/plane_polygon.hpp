#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <vector>

/// Faces in a plane: shape functions, cutting, integrals. Internal to common/problem.
namespace ricochet::surface {

/// A place in the plane of a face; along an edge the second coordinate is 0.
using Place = Eigen::Vector2d;
using Polygon = std::vector<Place>;   ///< of two corners: a piece of a line
using ShapeValues = Eigen::Vector4d;  ///< 0 beyond the corners of a face

inline double cross(const Place& a, const Place& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Shape functions of the face with these corners.
[[nodiscard]] ShapeValues shape_at(const Polygon& corners, const Place& place);

/// The part of `piece` within a convex polygon that is counter-clockwise (Sutherland, Hodgman 1974).
[[nodiscard]] Polygon clipped(Polygon piece, const Polygon& by);
/// No part of either can lie in the other.
[[nodiscard]] bool apart(const Polygon& a, const Polygon& b);
[[nodiscard]] inline Eigen::AlignedBox2d extent_of(const Polygon& polygon) {
  Eigen::AlignedBox2d extent;
  for (const Place& corner : polygon) extent.extend(corner);
  return extent;
}

/// Length of a line, area of a polygon.
[[nodiscard]] double measure_of(const Polygon& piece);

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

}  // namespace ricochet::surface
