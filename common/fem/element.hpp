#pragma once

#include <Eigen/Core>

#include "common/fem/element_kind.hpp"
#include "common/fem/model.hpp"

/// Finite elements of small strain, linear elastic, of any kind (element_kind.hpp).
/// Coordinates `x`: one row per node, two columns (bar: second column ignored), three of a solid.
/// Strain order: bar (xx); plane strain (xx, yy, zz, xy); axisymmetric (rr, zz, tt, rz); solid (xx, yy,
/// zz, xy, yz, zx); shear as 2 e_xy.
namespace ricochet::fem {

/// One element: what it is and where its nodes are [m].
struct ElementGeometry {
  ElementKind kind = ElementKind::bar;
  ElementCoordinates x;
};

/// Elasticity matrix D, stress = D strain [Pa]; 1x1 for a bar (E), 6x6 for a solid, else 4x4.
[[nodiscard]] Eigen::MatrixXd elasticity(Model model, const Material& material);

/// The places of an element's nodes that its stiffness and stress are computed from, and with them their bits:
/// along every direction in which the model does not change relative to the first node, and rounded to 2^-36 of the
/// element's size. Copies of one element in a mesh, which the rounding of their places tells apart, so get the same
/// matrices to the last bit, whoever computes them, and a mesh of copies holds few (ElementCopies, StiffnessProduct).
/// It moves a node by less than 1e-11 of the size. A bar's places stay what they are: its waves are exact to round-off.
[[nodiscard]] ElementCoordinates matrix_places(Model model, const ElementGeometry& element);

/// K_e = integral of B^T D B dV [N/m].
[[nodiscard]] ElementMatrix element_stiffness(const Section& section, const Material& material,
                                              const ElementGeometry& element);

/// Row-sum lumped mass per node: m_i = rho * integral of N_i dV [kg]; all positive, also on the axis r = 0.
[[nodiscard]] Eigen::VectorXd element_lumped_mass(const Section& section, const Material& material,
                                                  const ElementGeometry& element);

/// Integral of N_i dV per node [m^3] (times a body force per volume gives nodal forces). Exact in all models.
[[nodiscard]] Eigen::VectorXd element_volume(const Section& section, const ElementGeometry& element);

/// Stress at a point of the element, in its kind's natural coordinates, from nodal displacements `u` (node-major) [Pa].
/// On the axis r = 0 the hoop strain u_r/r is taken as its limit u_r,r.
[[nodiscard]] StressVector element_stress(const Section& section, const Material& material,
                                          const ElementGeometry& element, const ElementVector& u,
                                          const NaturalPoint& at);

/// Length of the shortest and of the longest edge of an element [m].
struct EdgeLengths {
  double shortest, longest;
};
[[nodiscard]] EdgeLengths edge_lengths(const ElementGeometry& element);

/// Integral of N_i dA over an edge, for its two nodes [m^2] (bar: the cross section, all on the first).
[[nodiscard]] Eigen::Vector2d edge_area(const Section& section, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

/// The quadrature points of an element that may yield; its kind must have some.
[[nodiscard]] std::vector<ElementPoint> element_points(const Section& section, const ElementGeometry& element);

/// The element's largest natural frequency squared: largest eigenvalue of M_e^-1 K_e with its own lumped mass [1/s^2].
/// The largest over the elements bounds that of their assembly from above, which gives a safe critical time step.
/// Source: Hughes, The Finite Element Method, section 9.3 (Irons and Treharne).
[[nodiscard]] double element_max_frequency_squared(const Section& section, const Material& material,
                                                   const ElementGeometry& element);

/// Whether that frequency squared is above `limit` [1/s^2]. The largest diagonal entry of M_e^-1/2 K_e M_e^-1/2 bounds
/// it from below and the largest row sum of magnitudes from above, so that few elements of a graded mesh need the
/// eigenvalue itself.
[[nodiscard]] bool element_frequency_squared_above(const Section& section, const Material& material,
                                                   const ElementGeometry& element, double limit);

/// R s R^T of a symmetric tensor in the order above, whose shears are those of the tensor; of plane strain or a solid.
[[nodiscard]] StressVector turned(const StressVector& tensor, const Eigen::Matrix3d& rotation);

/// Principal stresses, algebraically largest first, of a stress in the order above [Pa].
[[nodiscard]] Eigen::Vector3d principal_stresses(Model model, const StressVector& stress);

/// sqrt(3/2 s:s) of the deviator s of a stress in the order above: what uniaxial tension of the same distortion energy
/// has; of a bar the magnitude of its stress [Pa].
[[nodiscard]] double von_mises_stress(Model model, const StressVector& stress);

/// c_L = sqrt(E(1-nu)/(rho(1+nu)(1-2nu))) (Eq. 26); for a bar sqrt(E/rho) [m/s].
[[nodiscard]] double longitudinal_wave_speed(Model model, const Material& material);
/// c_S = sqrt(E/(2 rho (1+nu))) (Eq. 27) [m/s].
[[nodiscard]] double shear_wave_speed(const Material& material);

}  // namespace ricochet::fem
