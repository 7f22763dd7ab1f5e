#include "common/fem/tetrahedron.hpp"

#include "common/fem/solid.hpp"

namespace ricochet::fem {
namespace {

struct LinearSolid {
  static constexpr int nodes = 4;
  static constexpr double near = 0.13819660112501051518, far = 0.58541019662496845446, weight = 1.0 / 24.0;
  static constexpr SolidPoint points[4] = {
      {near, near, near, weight}, {far, near, near, weight}, {near, far, near, weight}, {near, near, far, weight}};

  static Eigen::Vector4d at(const NaturalPoint& p) { return {1.0 - p.sum(), p[0], p[1], p[2]}; }
  static Eigen::Matrix<double, 4, 3> natural_gradient(const NaturalPoint&) {
    Eigen::Matrix<double, 4, 3> gradient;
    gradient << -1.0, -1.0, -1.0, Eigen::Matrix3d::Identity();
    return gradient;
  }
};

using Tetrahedron = Solid<LinearSolid>;

}  // namespace

ElementMatrix tetrahedron_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  const Tetrahedron::Coordinates places = Tetrahedron::places(x);
  const Eigen::Matrix<double, 6, 6> d = elasticity(section.model, material);
  const Tetrahedron::StrainOperator b = Tetrahedron::strain_operator(places, NaturalPoint::Zero());
  const double volume = Tetrahedron::jacobian_matrix(places, NaturalPoint::Zero()).determinant() / 6.0;
  const Eigen::Matrix<double, 12, 12> stiffness = volume * (b.transpose() * d * b);
  return 0.5 * (stiffness + stiffness.transpose());
}

Eigen::VectorXd tetrahedron_volume(const Section&, const ElementCoordinates& x) {
  return Tetrahedron::volume(Tetrahedron::places(x));
}

StressVector tetrahedron_stress(const Section& section, const Material& material, const ElementCoordinates& x,
                                const ElementVector& u, const NaturalPoint& at) {
  return elasticity(section.model, material) * (Tetrahedron::strain_operator(Tetrahedron::places(x), at) * u);
}

double tetrahedron_jacobian(const ElementCoordinates& x, const NaturalPoint& at) {
  return Tetrahedron::jacobian(x, at);
}

}  // namespace ricochet::fem
