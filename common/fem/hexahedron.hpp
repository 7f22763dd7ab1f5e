#pragma once

#include "common/fem/element.hpp"

/// Eight-node hexahedron with enhanced assumed strains (Simo, Rifai 1990; Simo, Armero, Taylor 1993). To the strains of
/// the trilinear displacement twelve modes are added that each element has for itself and that are eliminated in it:
///   nine, the gradients of u_c = xi_k^2, which let it bend without shear (the incompatible modes of Taylor, Beresford,
///   Wilson 1976), and
///   three volume strains xi eta, eta zeta, zeta xi, without which the other nine leave four conditions of constant
///   volume per element where there are three components of displacement, and it locks as nu -> 1/2.
/// All are taken with J and det J of the middle, e = (det J_0 / det J) e_0, so that none does work against a constant
/// stress: the patch test is passed by any shape. Elasticity is linear, so K_e is as constant as any other element's.
/// With a material that yields it has no modes, which would follow the plastic strain, but at every point the element's
/// mean volume strain (mean_volume_strain.hpp): it then bends stiffly.
namespace ricochet::fem {

[[nodiscard]] ElementMatrix hexahedron_stiffness(const Section& section, const Material& material,
                                                 const ElementCoordinates& x);
[[nodiscard]] Eigen::VectorXd hexahedron_volume(const Section& section, const ElementCoordinates& x);
[[nodiscard]] StressVector hexahedron_stress(const Section& section, const Material& material,
                                             const ElementCoordinates& x, const ElementVector& u,
                                             const NaturalPoint& at);
[[nodiscard]] double hexahedron_jacobian(const ElementCoordinates& x, const NaturalPoint& at);
[[nodiscard]] std::vector<ElementPoint> hexahedron_points(const Section& section, const ElementCoordinates& x);

}  // namespace ricochet::fem
