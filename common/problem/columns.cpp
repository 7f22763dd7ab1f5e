#include "common/problem/columns.hpp"

#include <algorithm>
#include <cmath>

#include "common/fem/mesh.hpp"

namespace ricochet::scene {
namespace {

/// Share of an edge.
constexpr double aside = 1e-4;

double across(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a[0] * b[1] - a[1] * b[0]; }

}  // namespace

Columns::Columns(const Triangles& triangles, const std::vector<Eigen::Vector3d>& x, const Eigen::Vector3d& low,
                 const Eigen::Vector3d& high, double shortest_m)
    : triangles_(triangles),
      x_(x),
      low_(low),
      aside_m_(aside * shortest_m),
      cells_(1 + static_cast<int>(std::sqrt(0.5 * static_cast<double>(triangles.size())))),
      over_(fem::at(cells_ * cells_)) {
  for (int axis = 0; axis < 2; ++axis) per_m_[axis] = cells_ / std::max(high[axis] - low[axis], aside_m_);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [i, j, k] = triangles[t];
    const Eigen::Vector3d least = x[fem::at(i)].cwiseMin(x[fem::at(j)]).cwiseMin(x[fem::at(k)]),
                          most = x[fem::at(i)].cwiseMax(x[fem::at(j)]).cwiseMax(x[fem::at(k)]);
    for (int row = cell(least, 1); row <= cell(most, 1); ++row)
      for (int column = cell(least, 0); column <= cell(most, 0); ++column)
        over_[fem::at(row * cells_ + column)].push_back(static_cast<int>(t));
  }
}

int Columns::cell(const Eigen::Vector3d& place, int axis) const {
  return static_cast<int>(std::clamp((place[axis] - low_[axis]) * per_m_[axis], 0.0, cells_ - 1.0));
}

/// A little aside of the place, since edges of one mesh often lie above nodes of another.
bool Columns::within(const Eigen::Vector3d& place) const {
  const Eigen::Vector3d p = place + aside_m_ * Eigen::Vector3d(0.618, 0.377, 0.0);
  bool inside = false;
  for (const int t : over_[fem::at(cell(p, 1) * cells_ + cell(p, 0))]) {
    const auto& [i, j, k] = triangles_[fem::at(t)];
    const Eigen::Vector3d a = x_[fem::at(i)] - p, b = x_[fem::at(j)] - p, c = x_[fem::at(k)] - p;
    const double u = across(b, c), v = across(c, a), w = across(a, b);
    const bool crossed = (u > 0.0) == (v > 0.0) && (v > 0.0) == (w > 0.0);
    if (crossed && (u * a[2] + v * b[2] + w * c[2]) / (u + v + w) > 0.0) inside = !inside;
  }
  return inside;
}

}  // namespace ricochet::scene
