#include "common/body/plastic_bars.hpp"

#include <algorithm>
#include <cmath>

#include "common/body/linear_elements.hpp"

namespace ricochet::solver {

PlasticBars::PlasticBars(const BodyState& state)
    : state_(&state),
      young_pa_(state.part.material.youngs_modulus_pa),
      area_m2_(state.part.section.measure),
      law_(*state.part.material.plasticity),
      all_{{0, state.part.dofs()}},
      settled_(state.plastic),
      step_(*settled_),
      tried_(*settled_) {
  const auto& mesh = state.part.mesh;
  for (const auto& bar : mesh.elements)
    length_m_.push_back(mesh.position[fem::at(bar[1])][0] - mesh.position[fem::at(bar[0])][0]);
  asked_.u.setZero(state.part.dofs());
  asked_.flows.assign(mesh.elements.size(), false);
  settled_tangent_ = asked_;
}

double PlasticBars::strain(std::size_t element, const Eigen::VectorXd& u) const {
  const auto& bar = state_->part.mesh.elements[element];
  return (u[bar[1]] - u[bar[0]]) / length_m_[element];
}

double PlasticBars::excess(Eigen::Index element, double trial_pa) const {
  return std::abs(trial_pa) - (law_.yield_stress_pa + law_.hardening_pa * step_.equivalent[element]);
}

void PlasticBars::evaluate(Eigen::VectorXd& u, Eigen::VectorXd& force) {
  force.setZero();
  double work_j = 0.0;
  for (std::size_t element = 0; element < length_m_.size(); ++element) {
    const auto e = static_cast<Eigen::Index>(element);
    double stress_pa = young_pa_ * (strain(element, u) - step_.strain[e]), flow = 0.0;
    const double excess_pa = excess(e, stress_pa);
    if (excess_pa > 0.0) {
      flow = std::copysign(excess_pa / (young_pa_ + law_.hardening_pa), stress_pa);
      stress_pa -= young_pa_ * flow;
      work_j += area_m2_ * length_m_[element] * 0.5 * (step_.stress_pa[e] + stress_pa) * flow;
    }
    tried_.strain[e] = step_.strain[e] + flow;
    tried_.equivalent[e] = step_.equivalent[e] + std::abs(flow);
    tried_.stress_pa[e] = stress_pa;
    const auto& bar = state_->part.mesh.elements[element];
    force[bar[0]] -= area_m2_ * stress_pa;
    force[bar[1]] += area_m2_ * stress_pa;
  }
  tried_.work_j = step_.work_j + work_j;
}

void PlasticBars::settle() {
  *settled_ = step_;
  settled_tangent_ = asked_;
}

double PlasticBars::stored(const Eigen::VectorXd& u, double) const {
  double energy_j = 0.0;
  for (std::size_t element = 0; element < length_m_.size(); ++element) {
    const double elastic = strain(element, u) - settled_->strain[static_cast<Eigen::Index>(element)];
    energy_j += 0.5 * young_pa_ * area_m2_ * length_m_[element] * elastic * elastic;
  }
  return energy_j;
}

void PlasticBars::find_flowing(const Eigen::VectorXd& u) {
  asked_.u = u;
  for (std::size_t element = 0; element < length_m_.size(); ++element) {
    const auto e = static_cast<Eigen::Index>(element);
    asked_.flows[element] = excess(e, young_pa_ * (strain(element, u) - step_.strain[e])) > 0.0;
  }
}

const fem::SparseMatrix& PlasticBars::tangent(const Eigen::VectorXd& u) {
  if (u == settled_tangent_.u) {
    asked_ = settled_tangent_;
  } else {
    find_flowing(u);
  }
  const double plastic_pa = young_pa_ * law_.hardening_pa / (young_pa_ + law_.hardening_pa);
  tangent_ = state_->part.stiffness;
  tangent_ *= 0.0;
  for (std::size_t element = 0; element < length_m_.size(); ++element) {
    const auto& bar = state_->part.mesh.elements[element];
    const double k = (asked_.flows[element] ? plastic_pa : young_pa_) * area_m2_ / length_m_[element];
    for (const int row : {0, 1}) {
      for (const int column : {0, 1})
        tangent_.coeffRef(bar[fem::at(row)], bar[fem::at(column)]) += row == column ? k : -k;
    }
  }
  return tangent_;
}

void PlasticBars::archive(Archive& a) {
  a(*settled_, settled_tangent_);
  if (!a.reading()) return;
  step_ = tried_ = *settled_;
  asked_ = settled_tangent_;
}

bool any_yields(const std::vector<BodyState>& states) {
  return std::any_of(states.begin(), states.end(), [](const BodyState& state) { return state.plastic != nullptr; });
}

std::unique_ptr<InternalForce> material_elements(const BodyState& state) {
  if (state.plastic) return std::make_unique<PlasticBars>(state);
  return linear_elements(state);
}

}  // namespace ricochet::solver
