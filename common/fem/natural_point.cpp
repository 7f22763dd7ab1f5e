#include "common/fem/natural_point.hpp"

#include <Eigen/LU>
#include <cmath>

namespace ricochet::fem {
namespace {

constexpr double outside = 1e-6;  // of an element, by the rounding of places

/// Triangles and tetrahedra have a corner at the origin of their natural coordinates, which are those of area or
/// volume; the others reach from -1 to 1.
bool simplex(ElementKind kind) { return kind == ElementKind::triangle || kind == ElementKind::tetrahedron; }

/// N_i,a: one row per node.
Eigen::MatrixXd natural_gradient(ElementKind kind, const NaturalPoint& at) {
  const auto& traits = fem::traits(kind);
  Eigen::MatrixXd gradient(traits.nodes, traits.dimension);
  for (int i = 0; i < traits.nodes; ++i) {
    const NaturalPoint& corner = traits.corner[static_cast<std::size_t>(i)];
    for (int a = 0; a < traits.dimension; ++a) {
      gradient(i, a) = simplex(kind) ? (i == 0 ? -1.0 : corner[a]) : 0.5 * corner[a];
      for (int b = 0; !simplex(kind) && b < traits.dimension; ++b)
        if (b != a) gradient(i, a) *= 0.5 * (1.0 + corner[b] * at[b]);
    }
  }
  return gradient;
}

bool inside(ElementKind kind, const NaturalPoint& at, double slack) {
  double sum = 0.0;
  for (int a = 0; a < traits(kind).dimension; ++a) {
    const double low = simplex(kind) ? -slack : -1.0 - slack;
    if (!(at[a] >= low && at[a] <= 1.0 + slack)) return false;
    sum += at[a];
  }
  return !simplex(kind) || sum <= 1.0 + slack;
}

}  // namespace

ShapeValues shape_values(ElementKind kind, const NaturalPoint& at) {
  const auto& traits = fem::traits(kind);
  ShapeValues values = ShapeValues::Ones(traits.nodes);
  if (simplex(kind)) {
    for (int i = 1; i < traits.nodes; ++i) {
      values[i] = at[i - 1];
      values[0] -= values[i];
    }
    return values;
  }
  for (int i = 0; i < traits.nodes; ++i) {
    const NaturalPoint& corner = traits.corner[static_cast<std::size_t>(i)];
    for (int a = 0; a < traits.dimension; ++a) values[i] *= 0.5 * (1.0 + corner[a] * at[a]);
  }
  return values;
}

std::optional<NaturalPoint> natural_point(const ElementGeometry& element, const Eigen::Vector3d& x) {
  constexpr int most_steps = 30;
  const auto& traits = fem::traits(element.kind);
  const int dimension = traits.dimension;
  const Eigen::MatrixXd nodes = element.x.leftCols(dimension);
  Eigen::VectorXd place(dimension);
  for (int a = 0; a < dimension; ++a) place[a] = x[a];
  const double size = (nodes.colwise().maxCoeff() - nodes.colwise().minCoeff()).maxCoeff();
  const bool near = ((place.transpose() - nodes.colwise().minCoeff()).array() >= -outside * size).all() &&
                    ((nodes.colwise().maxCoeff() - place.transpose()).array() >= -outside * size).all();
  if (!near) return std::nullopt;
  NaturalPoint at = traits.centre;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::VectorXd off = place - nodes.transpose() * shape_values(element.kind, at);
    const Eigen::MatrixXd jacobian = nodes.transpose() * natural_gradient(element.kind, at);
    const Eigen::VectorXd change = jacobian.partialPivLu().solve(off);
    for (int a = 0; a < dimension; ++a) at[a] += change[a];
    if (!inside(element.kind, at, 10.0)) return std::nullopt;
    if (change.cwiseAbs().maxCoeff() < 1e-14) break;
  }
  return inside(element.kind, at, outside) ? std::optional(at) : std::nullopt;
}

}  // namespace ricochet::fem
