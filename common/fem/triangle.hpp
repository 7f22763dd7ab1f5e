#pragma once

#include "common/fem/element_kind.hpp"

/// Three-node triangle, nodes counter-clockwise from (xi, eta) = (0, 0), (1, 0), (0, 1): N = (1 - xi - eta, xi, eta).
/// In plane strain its strain is constant. Three points inside it integrate polynomials of degree two exactly (Strang
/// and Fix 1973), so the volume N_i r dA of a ring, too, and none of them lies on the axis.
///
/// It meshes any outline, and is stiffer than a quadrilateral of its size: in bending (its edges cannot curve, and its
/// constant strain cannot follow a linear one), and more the closer Poisson's ratio is to 1/2 (volumetric locking:
/// each triangle may keep its volume only by one equation for its share of less than one node). docs/limits.md has
/// figures. See element.hpp for the functions' meaning and units.
namespace ricochet::fem {

[[nodiscard]] ElementMatrix triangle_stiffness(const Section& section, const Material& material,
                                               const ElementCoordinates& x);
[[nodiscard]] Eigen::VectorXd triangle_volume(const Section& section, const ElementCoordinates& x);
[[nodiscard]] StressVector triangle_stress(const Section& section, const Material& material,
                                           const ElementCoordinates& x, const ElementVector& u, const NaturalPoint& at);
[[nodiscard]] double triangle_jacobian(const ElementCoordinates& x, const NaturalPoint& at);

}  // namespace ricochet::fem
