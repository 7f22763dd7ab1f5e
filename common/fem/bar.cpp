#include "common/fem/bar.hpp"

namespace ricochet::fem {
namespace {

double length(const ElementCoordinates& x) { return x(1, 0) - x(0, 0); }

}  // namespace

ElementMatrix bar_stiffness(const Section& section, const Material& material, const ElementCoordinates& x) {
  const double k = material.youngs_modulus_pa * section.measure / length(x);
  ElementMatrix stiffness(2, 2);
  stiffness << k, -k, -k, k;
  return stiffness;
}

Eigen::VectorXd bar_volume(const Section& section, const ElementCoordinates& x) {
  return Eigen::VectorXd::Constant(2, 0.5 * section.measure * length(x));
}

StressVector bar_stress(const Section&, const Material& material, const ElementCoordinates& x, const ElementVector& u,
                        const NaturalPoint&) {
  return StressVector::Constant(1, material.youngs_modulus_pa * (u[1] - u[0]) / length(x));
}

std::vector<ElementPoint> bar_points(const Section& section, const ElementCoordinates& x) {
  ElementPoint middle{decltype(ElementPoint::gradient)::Zero(2, 3), section.measure * length(x)};
  middle.gradient.col(0) << -1.0 / length(x), 1.0 / length(x);
  return {middle};
}

double bar_jacobian(const ElementCoordinates& x, const NaturalPoint&) { return 0.5 * length(x); }

}  // namespace ricochet::fem
