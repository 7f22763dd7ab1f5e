// The dashpots of absorbing surfaces in the windows of ImplicitSolver.
#include "implicit_solver/implicit_solver.hpp"

namespace ricochet::implicit_solver {

/// Load on a dashpot's dof: `external_force` leaves out the parts without loads.
double ImplicitSolver::load_on(std::size_t b, int dof, const Eigen::VectorXd& external) const {
  return states_[b].external.zero() ? 0.0 : external[offsets_[b] + dof];
}

/// Of the dashpots' forces in q and df, what does not change with du: see the class comment.
void ImplicitSolver::damp_rhs() {
  const double dt = setup_.window_size_s;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    for (std::size_t i = 0; i < state.dashpots.size(); ++i) {
      const auto& d = state.dashpots[i];
      dashpot_load_[b][i] = load_on(b, d.dof, trial_.external);
      double change = 2.0 * d.coefficient_kg_s * state.v[d.dof];
      if (!state.external.zero()) change += d.force(state.v[d.dof]);  // df was formed with it in f_n
      rhs_[offsets_[b] + d.dof] += 0.25 * dt * dt * change;
    }
  }
}

/// The dashpots' forces at n + 1 join f.
void ImplicitSolver::set_dashpot_forces() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (std::size_t i = 0; i < states_[b].dashpots.size(); ++i) {
      const auto& d = states_[b].dashpots[i];
      const auto dof = offsets_[b] + d.dof;
      trial_.external[dof] = dashpot_load_[b][i] + d.force(trial_.velocity[dof]);
    }
  }
}

}  // namespace ricochet::implicit_solver
