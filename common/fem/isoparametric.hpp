#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "common/fem/element.hpp"
#include "common/fem/mean_volume_strain.hpp"

/// Integrals of plane isoparametric elements. `Shape` is a kind's shape functions and quadrature:
///   nodes                             how many
///   at(xi, eta)                       N_i, a vector
///   natural_gradient(xi, eta)         N_i,xi and N_i,eta, a row per node
///   points                            quadrature points {xi, eta, weight}
/// The strains are the model's:
///   plane strain:  e = (u_x,x; u_y,y; 0; u_x,y + u_y,x),     dV = thickness dA
///   axisymmetric:  e = (u_r,r; u_z,z; u_r/r; u_r,z + u_z,r), dV = 2 pi r dA
namespace ricochet::fem {

struct QuadraturePoint {
  double xi, eta, weight;
};

template <class Shape>
struct Isoparametric {
  static constexpr int nodes = Shape::nodes;
  using Gradient = Eigen::Matrix<double, nodes, 2>;
  using StrainOperator = Eigen::Matrix<double, 4, 2 * nodes>;

  /// The values that the integrands need at one point of the element.
  struct Point {
    Eigen::Matrix<double, nodes, 1> shape;  // N_i
    Gradient gradient;                      // N_i,x  N_i,y
    double radius = 0.0;                    // first coordinate
    double determinant = 0.0;               // det J
  };

  /// The columns that elements of this file have of ElementCoordinates.
  using PlaneCoordinates = Eigen::Matrix<double, Eigen::Dynamic, 2, 0, 4, 2>;

  static Point point_at(const PlaneCoordinates& x, double xi, double eta) {
    Point point;
    point.shape = Shape::at(xi, eta);
    const Gradient natural = Shape::natural_gradient(xi, eta);
    const Eigen::Matrix2d jacobian = natural.transpose() * x;  // J(a, c) = x_c,a
    point.determinant = jacobian.determinant();
    point.gradient = natural * jacobian.inverse().transpose();
    point.radius = point.shape.dot(x.col(0));
    return point;
  }

  static StrainOperator strain_operator(Model model, const Point& point, bool on_axis) {
    StrainOperator b = StrainOperator::Zero();
    for (int i = 0; i < nodes; ++i) {
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

  static double volume_factor(const Section& section, const Point& point) {
    const double radius = section.model == Model::axisymmetric ? point.radius : 1.0;
    return section.measure * radius * point.determinant;
  }

  /// Mean over the volume of the operator of volume strain.
  static Eigen::Matrix<double, 1, 2 * nodes> mean_volume_strain(const Section& section, const PlaneCoordinates& x) {
    Eigen::Matrix<double, 1, 2 * nodes> sum = Eigen::Matrix<double, 1, 2 * nodes>::Zero();
    double volume = 0.0;
    for (const QuadraturePoint& q : Shape::points) {
      const Point point = point_at(x, q.xi, q.eta);
      const double own = q.weight * volume_factor(section, point);
      sum += own * volume_strain(strain_operator(section.model, point, false));
      volume += own;
    }
    return sum / volume;
  }

  /// integral of B^T D B dV, symmetric to the last bit; of a material that yields with B-bar.
  static ElementMatrix stiffness(const Section& section, const Material& material, const PlaneCoordinates& x) {
    const Eigen::Matrix4d d = elasticity(section.model, material);
    Eigen::Matrix<double, 2 * nodes, 2 * nodes> sum = Eigen::Matrix<double, 2 * nodes, 2 * nodes>::Zero();
    Eigen::Matrix<double, 1, 2 * nodes> mean;
    if (material.plasticity) mean = mean_volume_strain(section, x);
    for (const QuadraturePoint& q : Shape::points) {
      const Point point = point_at(x, q.xi, q.eta);
      StrainOperator b = strain_operator(section.model, point, false);
      if (material.plasticity) take_volume_strain(mean, b);
      sum += q.weight * volume_factor(section, point) * (b.transpose() * d * b);
    }
    return 0.5 * (sum + sum.transpose());
  }

  /// integral of N_i dV.
  static Eigen::VectorXd volume(const Section& section, const PlaneCoordinates& x) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(nodes);
    for (const QuadraturePoint& q : Shape::points) {
      const Point point = point_at(x, q.xi, q.eta);
      sum += q.weight * volume_factor(section, point) * point.shape;
    }
    return sum;
  }

  /// D B u; on the axis with the limit u_r/r -> u_r,r (u_r = 0 there).
  static StressVector stress(const Section& section, const Material& material, const PlaneCoordinates& x,
                             const ElementVector& u, const NaturalPoint& at) {
    const Point point = point_at(x, at[0], at[1]);
    const bool on_axis = point.radius <= 1e-9 * x.col(0).maxCoeff();
    StrainOperator b = strain_operator(section.model, point, on_axis);
    if (material.plasticity) take_volume_strain(mean_volume_strain(section, x), b);
    return elasticity(section.model, material) * (b * u);
  }

  static std::vector<ElementPoint> element_points(const Section& section, const PlaneCoordinates& x) {
    std::vector<ElementPoint> points;
    for (const QuadraturePoint& q : Shape::points) {
      const Point point = point_at(x, q.xi, q.eta);
      ElementPoint& own = points.emplace_back();
      own.gradient.setZero(nodes, 3);
      own.gradient.leftCols(2) = point.gradient;
      if (section.model == Model::axisymmetric) own.gradient.col(2) = point.shape / point.radius;
      own.volume_m3 = q.weight * volume_factor(section, point);
    }
    return points;
  }

  /// det J.
  static double jacobian(const PlaneCoordinates& x, const NaturalPoint& at) {
    const Eigen::Matrix2d j = Shape::natural_gradient(at[0], at[1]).transpose() * x;
    return j.determinant();
  }
};

}  // namespace ricochet::fem
