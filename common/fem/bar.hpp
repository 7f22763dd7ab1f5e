#pragma once

#include "common/fem/element_kind.hpp"

/// Two-node bar of constant strain e = (u_2 - u_1)/h, h = x_2 - x_1 > 0; `section.measure` is the cross section A.
/// Nothing varies along it, so no quadrature is needed and a point in it is not looked at. See element.hpp for shapes
/// and units.
namespace ricochet::fem {

/// K = E A/h [1 -1; -1 1].
[[nodiscard]] ElementMatrix bar_stiffness(const Section& section, const Material& material,
                                          const ElementCoordinates& x);
/// A h/2 for each node.
[[nodiscard]] Eigen::VectorXd bar_volume(const Section& section, const ElementCoordinates& x);
/// E (u_2 - u_1)/h.
[[nodiscard]] StressVector bar_stress(const Section& section, const Material& material, const ElementCoordinates& x,
                                      const ElementVector& u, const NaturalPoint& at);
/// h/2.
[[nodiscard]] double bar_jacobian(const ElementCoordinates& x, const NaturalPoint& at);
/// One.
[[nodiscard]] std::vector<ElementPoint> bar_points(const Section& section, const ElementCoordinates& x);

}  // namespace ricochet::fem
