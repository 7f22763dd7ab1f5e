#include <algorithm>
#include <cmath>
#include <limits>

#include "common/body/plastic_elements.hpp"
#include "common/fem/element_copies.hpp"

// The constructor of PlasticElements: shapes and blocks, found once from mesh and materials.

namespace ricochet::solver {
namespace {

/// Rounding must not let a point pass its yield stress unseen.
constexpr double caution = 1.001;

fem::Plasticity law_of(const fem::Material& material) {
  return material.plasticity.value_or(fem::Plasticity{.yield_stress_pa = std::numeric_limits<double>::infinity()});
}

}  // namespace

PlasticElements::PlasticElements(const BodyState& state)
    : state_(&state),
      laws_{law_of(state.part.material)},
      factor_squared_(state.part.section.model == fem::Model::bar ? 1.0 : 1.5),
      round_(state.part.section.model == fem::Model::axisymmetric),
      all_{{0, state.part.dofs()}},
      settled_(state.plastic),
      step_(*settled_) {
  for (const fem::Material& material : state.part.mesh.materials) laws_.push_back(law_of(material));
  set_shapes();
  set_blocks();
  u_settled_ = u_step_ = state.u;
}

void PlasticElements::set_shapes() {
  const auto& part = state_->part;
  fem::ElementCopies<int> copies(part.section.model);
  // In axisymmetry u_r moves a strain by its gradient and by itself.
  const double times = round_ ? std::sqrt(2.0) : 1.0;
  double scale = 0.0;
  const auto make = [&](const fem::ElementGeometry& geometry) {
    Shape& shape = shapes_.emplace_back();
    const auto points = fem::element_points(part.section, geometry);
    for (const auto& point : points) shape.volume_m3.push_back(point.volume_m3);
    for (const auto& point : points) {
      double norms = 0.0;
      for (Eigen::Index i = 0; i < point.gradient.rows(); ++i) norms += point.gradient.row(i).norm();
      shape.pa_per_m = std::max(shape.pa_per_m, scale * norms);
    }
    for (Eigen::Index i = 0; i < points.front().gradient.rows(); ++i)
      for (int c = 0; c < 3; ++c)
        for (const auto& point : points) shape.gradients.push_back(point.gradient(i, c));
    return static_cast<int>(shapes_.size()) - 1;
  };
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    scale = caution * times * std::sqrt(factor_squared_) * settled_->modulus_pa(e);
    shape_of_.push_back(copies.of(fem::element_geometry(part.mesh, e), make, fem::material_index(part.mesh, e)));
  }
}

void PlasticElements::set_blocks() {
  const auto& elements = state_->part.mesh.elements;
  due_m_.assign(elements.size(), 0.0);
  for (std::size_t first = 0; first < elements.size(); first += elements_of_block) {
    const std::size_t end = std::min(elements.size(), first + elements_of_block);
    Block& block = blocks_.emplace_back();
    block.first = static_cast<int>(first);
    block.end = static_cast<int>(end);
    for (std::size_t e = first; e < end; ++e)
      block.nodes.insert(block.nodes.end(), elements[e].begin(), elements[e].end());
    std::sort(block.nodes.begin(), block.nodes.end());
    block.nodes.erase(std::unique(block.nodes.begin(), block.nodes.end()), block.nodes.end());
  }
}

}  // namespace ricochet::solver
