#include "common/fem/quadrilateral.hpp"

#include "common/fem/isoparametric.hpp"

namespace ricochet::fem {
namespace {

struct Bilinear {
  static constexpr int nodes = 4;
  static constexpr double node_xi[4] = {-1.0, 1.0, 1.0, -1.0};
  static constexpr double node_eta[4] = {-1.0, -1.0, 1.0, 1.0};
  static constexpr double gauss = 0.57735026918962576451;  // 1/sqrt(3)
  static constexpr QuadraturePoint points[4] = {
      {-gauss, -gauss, 1.0}, {gauss, -gauss, 1.0}, {gauss, gauss, 1.0}, {-gauss, gauss, 1.0}};

  static Eigen::Vector4d at(double xi, double eta) {
    Eigen::Vector4d shape;
    for (int i = 0; i < 4; ++i) shape[i] = 0.25 * (1.0 + node_xi[i] * xi) * (1.0 + node_eta[i] * eta);
    return shape;
  }
  static Eigen::Matrix<double, 4, 2> natural_gradient(double xi, double eta) {
    Eigen::Matrix<double, 4, 2> gradient;
    for (int i = 0; i < 4; ++i) {
      gradient(i, 0) = 0.25 * node_xi[i] * (1.0 + node_eta[i] * eta);
      gradient(i, 1) = 0.25 * node_eta[i] * (1.0 + node_xi[i] * xi);
    }
    return gradient;
  }
};

using Quadrilateral = Isoparametric<Bilinear>;

}  // namespace

ElementMatrix quadrilateral_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  return Quadrilateral::stiffness(section, material, x);
}

Eigen::VectorXd quadrilateral_volume(const Section& section, const ElementCoordinates& x) {
  return Quadrilateral::volume(section, x);
}

StressVector quadrilateral_stress(const Section& section, const Material& material, const ElementCoordinates& x,
                                  const ElementVector& u, const NaturalPoint& at) {
  return Quadrilateral::stress(section, material, x, u, at);
}

std::vector<ElementPoint> quadrilateral_points(const Section& section, const ElementCoordinates& x) {
  return Quadrilateral::element_points(section, x);
}

double quadrilateral_jacobian(const ElementCoordinates& x, const NaturalPoint& at) {
  return Quadrilateral::jacobian(x, at);
}

}  // namespace ricochet::fem
