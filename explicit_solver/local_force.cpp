#include "explicit_solver/local_force.hpp"

#include <utility>

#include "common/body/material_elements.hpp"
#include "common/body/turning_elements.hpp"
#include "explicit_solver/material_force.hpp"

namespace ricochet::explicit_solver {

LocalForce::LocalForce(const solver::BodyState& state, std::unique_ptr<solver::InternalForce> elements,
                       fem::LocalSteps steps)
    : state_(&state), steps_(std::move(steps)), elements_(std::move(elements)) {
  steps_.compute_with(state.parallel);
  if (steps_.any() && !state.u.isZero(0.0)) {
    const Eigen::VectorXd u = straining();
    Eigen::VectorXd force(u.size());
    state.stiffness.multiply(u, force);
    start_j_ = 0.5 * over_reached(u, force);
    steps_.spread(force);
    start_j_ -= 0.5 * over_reached(u, force);
  }
  if (steps_.any() && state.plastic) flow_.emplace(Flow{0.0, 0.0, {}, straining(), state.plastic->force_n});
}

/// The displacement that strains, of the present motion.
Eigen::VectorXd LocalForce::straining() const {
  return state_->frame ? state_->frame->straining(state_->u) : state_->u;
}

double LocalForce::over_reached(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  const int components = fem::components(state_->part.mesh.model);
  double sum = 0.0;
  for (const int node : steps_.reached())
    for (int dof = node * components; dof < (node + 1) * components; ++dof) sum += a[dof] * b[dof];
  return sum;
}

void LocalForce::evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  elements_->evaluate(step_s, u, force);
  steps_.spread(force);
  if (flow_) flow_->u = u;
}

void LocalForce::settle() {
  elements_->settle();
  if (flow_) note_flow();
}

void LocalForce::note_flow() {
  if (const auto& plastic = *state_->plastic; plastic.work_j.sum() != flow_->plastic_work_j) {
    Eigen::VectorXd& spread = flow_->force;
    spread -= plastic.force_n;
    flow_->u_before += flow_->u;
    flow_->work_j -= 0.5 * over_reached(flow_->u_before, spread);
    steps_.spread(spread);
    flow_->work_j += 0.5 * over_reached(flow_->u_before, spread);
    flow_->force = plastic.force_n;
    flow_->plastic_work_j = plastic.work_j.sum();
  }
  flow_->u_before.swap(flow_->u);
}

bool LocalForce::spreads(int dof) const {
  return steps_.any() && steps_.steps_locally(dof / fem::components(state_->part.mesh.model));
}

LocalForce::Unspread LocalForce::unspread(const Eigen::VectorXd& u, const Eigen::VectorXd& force) {
  if (!steps_.any()) return {};
  Eigen::VectorXd elements(u.size());
  state_->stiffness.multiply(u, elements);
  if (flow_) elements -= state_->plastic->force_n;
  Unspread found;
  elements -= force;
  found.half_work_j = 0.5 * over_reached(u, elements);
  found.work_j = found.half_work_j - start_j_;
  if (!flow_) return found;
  const Eigen::VectorXd& plastic = state_->plastic->force_n;
  Eigen::VectorXd left_out = plastic;
  steps_.spread(left_out);
  left_out -= plastic;
  found.work_j += flow_->work_j + 0.5 * over_reached(u, left_out);
  return found;
}

void LocalForce::archive(Archive& a) {
  elements_->archive(a);
  if (!flow_) return;
  a(flow_->work_j);
  if (!a.reading()) return;
  flow_->u_before = straining();
  flow_->force = state_->plastic->force_n;
  flow_->plastic_work_j = state_->plastic->work_j.sum();
}

std::unique_ptr<solver::InternalForce> local_force(const solver::BodyState& state, const std::vector<int>& driven,
                                                   fem::LocalSteps steps) {
  if (state.frame)
    return std::make_unique<solver::TurningElements>(
        state, std::make_unique<LocalForce>(state, solver::straining_elements(state), std::move(steps)));
  std::vector<int> nodes = driven;
  nodes.insert(nodes.end(), steps.reached().begin(), steps.reached().end());
  return std::make_unique<LocalForce>(state, material_force(state, nodes), std::move(steps));
}

}  // namespace ricochet::explicit_solver
