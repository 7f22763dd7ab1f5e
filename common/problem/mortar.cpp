#include "common/problem/mortar.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

namespace ricochet::scene {
namespace {

/// An edge of which less lies opposite the other surface touches nothing: its dual basis would be round-off.
constexpr double least_share = 1e-4;

/// Shape functions of an edge at a place.
Eigen::Vector2d shape(const SurfaceEdge& edge, double along_m) {
  const double share = (along_m - edge.along_m[0]) / (edge.along_m[1] - edge.along_m[0]);
  return {1.0 - share, share};
}

/// What lies opposite an edge.
struct Segment {
  double low_m, high_m;
  const SurfaceEdge* opposite;
  double shift_m;  ///< the opposite edge is moved by
};

/// Sums f(place, weight) over the Gauss points of a segment: exact for the products of three linear functions.
template <class F>
void integrate(const SurfaceEdge& edge, const Segment& segment, const F& f) {
  const double half = 0.5 * (segment.high_m - segment.low_m), middle = 0.5 * (segment.low_m + segment.high_m);
  for (const double sign : {-1.0, 1.0}) {
    const double place = middle + sign * half / std::sqrt(3.0);
    const Eigen::Vector2d n = shape(edge, place);
    f(place, half * (n[0] * edge.measure[0] + n[1] * edge.measure[1]));
  }
}

/// The second surface's edges, ascending, with their images where the line repeats.
class Opposite {
 public:
  Opposite(const std::vector<SurfaceEdge>& edges, double period_m) {
    for (const auto& edge : edges) {
      longest_m_ = std::max(longest_m_, edge.along_m[1] - edge.along_m[0]);
      images_.push_back({&edge, 0.0});
      if (period_m == 0.0) continue;
      images_.push_back({&edge, -period_m});
      images_.push_back({&edge, period_m});
    }
    std::sort(images_.begin(), images_.end(), [](const Image& x, const Image& y) { return x.low_m() < y.low_m(); });
  }
  [[nodiscard]] std::vector<Segment> of(const SurfaceEdge& edge) const {
    std::vector<Segment> segments;
    const auto first = std::lower_bound(images_.begin(), images_.end(), edge.along_m[0] - longest_m_,
                                        [](const Image& image, double low_m) { return image.low_m() < low_m; });
    for (auto image = first; image != images_.end() && image->low_m() < edge.along_m[1]; ++image) {
      const double low = std::max(edge.along_m[0], image->low_m());
      const double high = std::min(edge.along_m[1], image->edge->along_m[1] + image->shift_m);
      if (high > low) segments.push_back({low, high, image->edge, image->shift_m});
    }
    return segments;
  }

 private:
  struct Image {
    const SurfaceEdge* edge;
    double shift_m;
    [[nodiscard]] double low_m() const { return edge->along_m[0] + shift_m; }
  };
  std::vector<Image> images_;
  double longest_m_ = 0.0;
};

}  // namespace

std::vector<MortarRow> mortar_rows(const std::vector<SurfaceEdge>& first, const std::vector<SurfaceEdge>& second,
                                   double period_m) {
  const Opposite opposite(second, period_m);
  std::map<int, double> area;
  std::map<int, std::map<int, double>> coupling;  // integral psi_j phi_k
  for (const auto& edge : first) {
    const auto segments = opposite.of(edge);
    double covered_m = 0.0;
    Eigen::Vector2d d = Eigen::Vector2d::Zero();
    Eigen::Matrix2d m = Eigen::Matrix2d::Zero();
    for (const auto& segment : segments) {
      covered_m += segment.high_m - segment.low_m;
      integrate(edge, segment, [&](double place, double weight) {
        const Eigen::Vector2d phi = shape(edge, place);
        d += weight * phi;
        m += weight * phi * phi.transpose();
      });
    }
    if (covered_m < least_share * (edge.along_m[1] - edge.along_m[0])) continue;
    const Eigen::Matrix2d dual = d.asDiagonal() * m.inverse();
    for (std::size_t j = 0; j < 2; ++j) area[edge.node[j]] += d[static_cast<Eigen::Index>(j)];
    for (const auto& segment : segments) {
      integrate(edge, segment, [&](double place, double weight) {
        const Eigen::Vector2d psi = dual * shape(edge, place);
        const Eigen::Vector2d phi = shape(*segment.opposite, place - segment.shift_m);
        for (std::size_t j = 0; j < 2; ++j) {
          for (std::size_t k = 0; k < 2; ++k)
            coupling[edge.node[j]][segment.opposite->node[k]] +=
                weight * psi[static_cast<Eigen::Index>(j)] * phi[static_cast<Eigen::Index>(k)];
        }
      });
    }
  }
  std::vector<MortarRow> rows;
  for (const auto& [node, area_m2] : area) {
    MortarRow row{node, area_m2, {}};
    for (const auto& [other, value] : coupling[node]) {
      if (std::abs(value) > 1e-14 * area_m2) row.opposite.push_back({other, value / area_m2});
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace ricochet::scene
