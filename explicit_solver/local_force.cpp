#include "explicit_solver/local_force.hpp"

#include <memory>

namespace ricochet::explicit_solver {
namespace {

std::vector<int> with(std::vector<int> nodes, const std::vector<int>& more) {
  nodes.insert(nodes.end(), more.begin(), more.end());
  return nodes;
}

}  // namespace

LocalForce::LocalForce(const solver::BodyState& state, const std::vector<int>& driven, double window_s)
    : state_(&state),
      steps_(state.part.stiffness, state.inverse_mass, fem::components(state.part.mesh.model), window_s),
      elements_(material_force(state, with(driven, steps_.reached()))) {}

void LocalForce::evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  elements_->evaluate(step_s, u, force);
  steps_.spread(force);
}

bool LocalForce::spreads(int dof) const {
  return steps_.any() && steps_.steps_locally(dof / fem::components(state_->part.mesh.model));
}

double LocalForce::stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force, double half_work_j) const {
  if (!steps_.any()) return elements_->stored(u, force, half_work_j);
  Eigen::VectorXd unspread(u.size());
  state_->stiffness.multiply(u, unspread);
  if (state_->plastic) unspread -= state_->plastic->force_n;
  return elements_->stored(u, unspread, half_work_j + 0.5 * u.dot(unspread - force));
}

MakeForce local_force(double window_s) {
  return [window_s](const solver::BodyState& state, const std::vector<int>& driven) {
    return std::make_unique<LocalForce>(state, driven, window_s);
  };
}

}  // namespace ricochet::explicit_solver
