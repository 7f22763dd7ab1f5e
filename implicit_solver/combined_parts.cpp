#include "implicit_solver/combined_parts.hpp"

namespace ricochet::implicit_solver {
namespace {

fem::SparseMatrix block_diagonal(const std::vector<solver::BodyState>& states,
                                 const std::vector<Eigen::Index>& offsets) {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::Index size = 0;
  for (std::size_t b = 0; b < states.size(); ++b) {
    const auto& k = states[b].part.stiffness;
    for (int row = 0; row < k.outerSize(); ++row) {
      for (fem::SparseMatrix::InnerIterator it(k, row); it; ++it) {
        entries.emplace_back(static_cast<int>(offsets[b]) + row, static_cast<int>(offsets[b] + it.col()), it.value());
      }
    }
    size += k.rows();
  }
  fem::SparseMatrix all(size, size);
  all.setFromTriplets(entries.begin(), entries.end());
  return all;
}

}  // namespace

CombinedParts::CombinedParts(std::vector<solver::BodyState>& bodies) : states(bodies) {
  Eigen::Index offset = 0;
  for (const auto& state : states) {
    offsets.push_back(offset);
    for (const int dof : state.shared_dofs) shared_dofs.push_back(static_cast<int>(offset) + dof);
    offset += state.part.dofs();
  }
  stiffness = block_diagonal(states, offsets);
}

void CombinedParts::external_force(double time_s, Eigen::VectorXd& external) const {
  for (std::size_t b = 0; b < states.size(); ++b) {
    if (states[b].external.zero()) continue;
    Eigen::VectorXd force(states[b].part.dofs());
    states[b].external.at(time_s, force);
    segment(external, b) = force;
  }
}

void CombinedParts::constrain_rates(double time_s, double dt, const WindowState& state, WindowTrial& trial) const {
  for (std::size_t b = 0; b < states.size(); ++b) {
    for (const auto& c : states[b].constrained) {
      const auto dof = static_cast<int>(offsets[b]) + c.dof;
      double internal = state.external[dof] - state.residual[dof] - state.link[dof];
      for (fem::SparseMatrix::InnerIterator it(stiffness, dof); it; ++it)
        internal += it.value() * trial.increment[it.col()];
      trial.velocity[dof] = c.velocity(time_s, dt);
      trial.acceleration[dof] = c.acceleration(time_s, dt);
      trial.end.residual[dof] = states[b].mass[c.dof] * trial.acceleration[dof];
      trial.end.external[dof] = trial.end.residual[dof] + internal + trial.end.link[dof];
    }
  }
}

}  // namespace ricochet::implicit_solver
