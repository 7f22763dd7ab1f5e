#pragma once

#include "common/fem/element_kind.hpp"

/// Four-node isoparametric quadrilateral, nodes counter-clockwise from (xi, eta) = (-1, -1), N_i bilinear.
/// 2x2 Gauss points integrate N_i dV exactly for straight edges (N_i r det J is cubic in each direction), and none of
/// them lies on the axis. det J is linear in xi and eta, so its smallest value is at a corner.
/// With a material that yields every point has the element's mean volume strain (mean_volume_strain.hpp).
/// See element.hpp for the functions' meaning and units.
namespace ricochet::fem {

[[nodiscard]] ElementMatrix quadrilateral_stiffness(const Section& section, const Material& material,
                                                    const ElementCoordinates& x);
[[nodiscard]] Eigen::VectorXd quadrilateral_volume(const Section& section, const ElementCoordinates& x);
[[nodiscard]] StressVector quadrilateral_stress(const Section& section, const Material& material,
                                                const ElementCoordinates& x, const ElementVector& u,
                                                const NaturalPoint& at);
[[nodiscard]] double quadrilateral_jacobian(const ElementCoordinates& x, const NaturalPoint& at);
[[nodiscard]] std::vector<ElementPoint> quadrilateral_points(const Section& section, const ElementCoordinates& x);

}  // namespace ricochet::fem
