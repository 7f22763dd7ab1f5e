#pragma once

#include "common/fem/element.hpp"

/// Four-node isoparametric quadrilateral, nodes counter-clockwise from (xi, eta) = (-1, -1), N_i bilinear.
///   plane strain:  e = (u_x,x; u_y,y; 0; u_x,y + u_y,x),     dV = thickness dA
///   axisymmetric:  e = (u_r,r; u_z,z; u_r/r; u_r,z + u_z,r), dV = 2 pi r dA
/// 2x2 Gauss points integrate N_i dV exactly for straight edges (N_i r det J is cubic in each direction), and none of
/// them lies on the axis. See element.hpp for shapes and units.
namespace ricochet::fem {

/// integral of B^T D B dV, symmetric to the last bit.
[[nodiscard]] ElementMatrix quadrilateral_stiffness(const Section& section, const Material& material,
                                                    const ElementCoordinates& x);
/// integral of N_i dV.
[[nodiscard]] Eigen::VectorXd quadrilateral_volume(const Section& section, const ElementCoordinates& x);
/// D B u at (xi, eta); on the axis with the limit u_r/r -> u_r,r (u_r = 0 there).
[[nodiscard]] StressVector quadrilateral_stress(const Section& section, const Material& material,
                                                const ElementCoordinates& x, const ElementVector& u, double xi,
                                                double eta);

/// det J at (xi, eta); it is linear in both, so its smallest value is at a corner [m^2].
[[nodiscard]] double jacobian_determinant(const ElementCoordinates& x, double xi, double eta);

/// Natural coordinates of the nodes.
inline constexpr double node_xi[4] = {-1.0, 1.0, 1.0, -1.0};
inline constexpr double node_eta[4] = {-1.0, -1.0, 1.0, 1.0};

}  // namespace ricochet::fem
