#include "common/fem/quadrilateral.hpp"

#include <Eigen/LU>

namespace ricochet::fem {
namespace {

constexpr double gauss = 0.57735026918962576451;  // 1/sqrt(3); the weights are 1

/// What the integrands need at one point of the element.
struct Point {
  Eigen::Vector4d shape;                 // N_i
  Eigen::Matrix<double, 4, 2> gradient;  // N_i,x  N_i,y
  double radius = 0.0;                   // first coordinate
  double determinant = 0.0;              // det J
};

Eigen::Matrix<double, 4, 2> natural_gradient(double xi, double eta) {
  Eigen::Matrix<double, 4, 2> gradient;
  for (int i = 0; i < 4; ++i) {
    gradient(i, 0) = 0.25 * node_xi[i] * (1.0 + node_eta[i] * eta);
    gradient(i, 1) = 0.25 * node_eta[i] * (1.0 + node_xi[i] * xi);
  }
  return gradient;
}

Point point_at(const ElementCoordinates& x, double xi, double eta) {
  Point point;
  for (int i = 0; i < 4; ++i) point.shape[i] = 0.25 * (1.0 + node_xi[i] * xi) * (1.0 + node_eta[i] * eta);
  const Eigen::Matrix<double, 4, 2> natural = natural_gradient(xi, eta);
  const Eigen::Matrix2d jacobian = natural.transpose() * x;  // J(a, c) = x_c,a
  point.determinant = jacobian.determinant();
  point.gradient = natural * jacobian.inverse().transpose();
  point.radius = point.shape.dot(x.col(0));
  return point;
}

Eigen::Matrix<double, 4, 8> strain_operator(Model model, const Point& point, bool on_axis) {
  Eigen::Matrix<double, 4, 8> b = Eigen::Matrix<double, 4, 8>::Zero();
  for (int i = 0; i < 4; ++i) {
    const double dx = point.gradient(i, 0);
    const double dy = point.gradient(i, 1);
    b(0, 2 * i) = dx;
    b(1, 2 * i + 1) = dy;
    b(3, 2 * i) = dy;
    b(3, 2 * i + 1) = dx;
    if (model == Model::axisymmetric) b(2, 2 * i) = on_axis ? dx : point.shape[i] / point.radius;
  }
  return b;
}

double volume_factor(const Section& section, const Point& point) {
  const double radius = section.model == Model::axisymmetric ? point.radius : 1.0;
  return section.measure * radius * point.determinant;
}

template <class Visit>
void for_each_gauss_point(const ElementCoordinates& x, Visit visit) {
  for (int i = 0; i < 4; ++i) visit(point_at(x, gauss * node_xi[i], gauss * node_eta[i]));
}

}  // namespace

double jacobian_determinant(const ElementCoordinates& x, double xi, double eta) {
  const Eigen::Matrix2d jacobian = natural_gradient(xi, eta).transpose() * x;
  return jacobian.determinant();
}

ElementMatrix quadrilateral_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  const Eigen::Matrix4d d = elasticity(section.model, material);
  Eigen::Matrix<double, 8, 8> stiffness = Eigen::Matrix<double, 8, 8>::Zero();
  for_each_gauss_point(x, [&](const Point& point) {
    const Eigen::Matrix<double, 4, 8> b = strain_operator(section.model, point, false);
    stiffness += volume_factor(section, point) * (b.transpose() * d * b);
  });
  return 0.5 * (stiffness + stiffness.transpose());
}

Eigen::VectorXd quadrilateral_volume(const Section& section, const ElementCoordinates& x) {
  Eigen::VectorXd volume = Eigen::VectorXd::Zero(4);
  for_each_gauss_point(x, [&](const Point& point) { volume += volume_factor(section, point) * point.shape; });
  return volume;
}

StressVector quadrilateral_stress(const Section& section, const Material& material, const ElementCoordinates& x,
                                  const ElementVector& u, double xi, double eta) {
  const Point point = point_at(x, xi, eta);
  const bool on_axis = point.radius <= 1e-9 * x.col(0).maxCoeff();
  return elasticity(section.model, material) * (strain_operator(section.model, point, on_axis) * u);
}

}  // namespace ricochet::fem
