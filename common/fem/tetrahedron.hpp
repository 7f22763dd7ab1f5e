#pragma once

#include "common/fem/element.hpp"

/// Four-node tetrahedron: one strain for all of it. It is too stiff in bending and locks towards nu = 1/2, more than
/// any other element here (docs/limits.md): it is there because meshers fill any body with it.
namespace ricochet::fem {

[[nodiscard]] ElementMatrix tetrahedron_stiffness(const Section& section, const Material& material,
                                                  const ElementCoordinates& x);
[[nodiscard]] Eigen::VectorXd tetrahedron_volume(const Section& section, const ElementCoordinates& x);
[[nodiscard]] StressVector tetrahedron_stress(const Section& section, const Material& material,
                                              const ElementCoordinates& x, const ElementVector& u,
                                              const NaturalPoint& at);
[[nodiscard]] double tetrahedron_jacobian(const ElementCoordinates& x, const NaturalPoint& at);

}  // namespace ricochet::fem
