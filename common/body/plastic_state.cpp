#include "common/body/plastic_state.hpp"

#include <cmath>

namespace ricochet::solver {

PlasticState::PlasticState(const fem::Part& part) : components(fem::stress_components(part.section.model)) {
  const auto& material = part.material;
  modulus_pa = material.youngs_modulus_pa;
  if (part.section.model != fem::Model::bar) modulus_pa /= 1.0 + material.poisson_ratio;
  if (!part.mesh.elements.empty())
    points = static_cast<int>(fem::element_points(part.section, fem::element_geometry(part.mesh, 0)).size());
  const Eigen::Index all = static_cast<Eigen::Index>(part.mesh.elements.size()) * points;
  strain.setZero(all * components);
  equivalent.setZero(all);
  if (const auto& heat = material.plasticity->heat) {
    temperature_k.setConstant(all, heat->reference_k);
    hottest_k = heat->reference_k;
  }
  force_n.setZero(part.dofs());
}

fem::StressVector PlasticState::strain_of(int element) const {
  fem::StressVector sum = fem::StressVector::Zero(components);
  for (int point = 0; point < points; ++point) sum += at(Eigen::Index{element} * points + point);
  sum /= points;
  for (int shear = 3; shear < components; ++shear) sum[shear] /= std::sqrt(2.0);
  return sum;
}

}  // namespace ricochet::solver
