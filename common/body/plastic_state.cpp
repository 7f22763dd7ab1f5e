#include "common/body/plastic_state.hpp"

#include <algorithm>
#include <cmath>

namespace ricochet::solver {

PlasticState::PlasticState(const fem::Part& part) : components(fem::stress_components(part.section.model)) {
  std::vector<fem::Material> materials{part.material};
  materials.insert(materials.end(), part.mesh.materials.begin(), part.mesh.materials.end());
  for (const fem::Material& material : materials) {
    moduli_pa.push_back(material.youngs_modulus_pa);
    if (part.section.model != fem::Model::bar) moduli_pa.back() /= 1.0 + material.poisson_ratio;
    if (material.plasticity && material.plasticity->heat)
      hottest_k = std::max(hottest_k, material.plasticity->heat->reference_k);
  }
  for (const int index : part.mesh.material) modulus.push_back(1 + index);
  if (!part.mesh.elements.empty())
    points = static_cast<int>(fem::element_points(part.section, fem::element_geometry(part.mesh, 0)).size());
  const Eigen::Index all = static_cast<Eigen::Index>(part.mesh.elements.size()) * points;
  strain.setZero(all * components);
  equivalent.setZero(all);
  if (hottest_k > 0.0) set_temperature(part, hottest_k);
  force_n.setZero(part.dofs());
  for (auto* sums : {&energy_j, &work_j}) sums->setZero(blocks_of(part.nodes()));
}

/// u . P/2 = u . K u/2 - u . force/2, and the elements store u . K u/2 - u . force + energy.
double PlasticState::stored_beyond_j(const Eigen::VectorXd& u, int block, int rows_of_node) const {
  const Eigen::Index first = Eigen::Index{block} * block_nodes * rows_of_node,
                     last = std::min(first + block_nodes * rows_of_node, force_n.size());
  double twice_j = 0.0;
  for (Eigen::Index row = first; row < last; ++row) twice_j += u[row] * force_n[row];
  return energy_j[block] - 0.5 * twice_j;
}

void PlasticState::set_temperature(const fem::Part& part, double elsewhere_k) {
  temperature_k.setConstant(equivalent.size(), elsewhere_k);
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const auto& plasticity = fem::material_of(part, e).plasticity;
    if (plasticity && plasticity->heat)
      temperature_k.segment(Eigen::Index{e} * points, points).setConstant(plasticity->heat->reference_k);
  }
}

fem::StressVector PlasticState::strain_of(int element) const {
  fem::StressVector sum = fem::StressVector::Zero(components);
  for (int point = 0; point < points; ++point) sum += at(Eigen::Index{element} * points + point);
  sum /= points;
  for (int shear = 3; shear < components; ++shear) sum[shear] /= std::sqrt(2.0);
  return sum;
}

void PlasticState::append_element(int element, std::vector<double>& numbers) const {
  visit_element(*this, element, [&](const double* own, int count) { numbers.insert(numbers.end(), own, own + count); });
}

const double* PlasticState::take_element(int element, const double* numbers) {
  visit_element(*this, element, [&](double* own, int count) {
    std::copy_n(numbers, count, own);
    numbers += count;
  });
  return numbers;
}

}  // namespace ricochet::solver
