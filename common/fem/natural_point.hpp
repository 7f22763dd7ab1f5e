#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/fem/element.hpp"

/// Where in an element a place lies.
namespace ricochet::fem {

using ShapeValues = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, Element::most_nodes, 1>;

/// N_i at a natural point, of kinds whose nodes are corners.
[[nodiscard]] ShapeValues shape_values(ElementKind kind, const NaturalPoint& at);

/// The natural point at which sum N_i x_i = x, by Newton's method; nothing if x lies outside the element by more than
/// 1e-6 of it.
[[nodiscard]] std::optional<NaturalPoint> natural_point(const ElementGeometry& element, const Eigen::Vector3d& x);

}  // namespace ricochet::fem
