#include "common/fem/triangle.hpp"

#include "common/fem/isoparametric.hpp"

namespace ricochet::fem {
namespace {

struct Linear {
  static constexpr int nodes = 3;
  static constexpr double near = 1.0 / 6.0, far = 2.0 / 3.0;
  static constexpr QuadraturePoint points[3] = {{near, near, near}, {far, near, near}, {near, far, near}};

  static Eigen::Vector3d at(double xi, double eta) { return {1.0 - xi - eta, xi, eta}; }
  static Eigen::Matrix<double, 3, 2> natural_gradient(double, double) {
    Eigen::Matrix<double, 3, 2> gradient;
    gradient << -1.0, -1.0, 1.0, 0.0, 0.0, 1.0;
    return gradient;
  }
};

using Triangle = Isoparametric<Linear>;

}  // namespace

ElementMatrix triangle_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  return Triangle::stiffness(section, material, x);
}

Eigen::VectorXd triangle_volume(const Section& section, const ElementCoordinates& x) {
  return Triangle::volume(section, x);
}

StressVector triangle_stress(const Section& section, const Material& material, const ElementCoordinates& x,
                             const ElementVector& u, const NaturalPoint& at) {
  return Triangle::stress(section, material, x, u, at);
}

double triangle_jacobian(const ElementCoordinates& x, const NaturalPoint& at) { return Triangle::jacobian(x, at); }

}  // namespace ricochet::fem
