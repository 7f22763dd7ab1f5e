#include "implicit_solver/combined_parts.hpp"

#include <algorithm>

namespace ricochet::implicit_solver {
CombinedParts::CombinedParts(std::vector<solver::BodyState>& bodies, const MakeForce& make_force) : states(bodies) {
  for (const auto& state : states) {
    forces.push_back(make_force(state));
    linear_ = linear_ && forces.back()->linear();
    keep_tangents_ = keep_tangents_ && forces.back()->keeps_tangent();
    offsets.push_back(dofs_);
    for (const int dof : state.shared_dofs) shared_dofs.push_back(static_cast<int>(dofs_) + dof);
    dofs_ += state.part.dofs();
  }
}

double CombinedParts::turning_m(std::size_t part) const {
  double largest_m = 0.0;
  if (states[part].frame)
    for (const auto& x : states[part].part.mesh.position) largest_m = std::max(largest_m, x.lpNorm<Eigen::Infinity>());
  return largest_m;
}

Eigen::VectorXd CombinedParts::displacement() const {
  Eigen::VectorXd u(dofs_);
  for (std::size_t b = 0; b < states.size(); ++b) segment(u, b) = states[b].u;
  return u;
}

std::size_t CombinedParts::part_of(Eigen::Index dof) const {
  return static_cast<std::size_t>(std::upper_bound(offsets.begin(), offsets.end(), dof) - offsets.begin() - 1);
}

std::vector<Eigen::Matrix3d> CombinedParts::rotations(const Eigen::VectorXd& u) const {
  std::vector<Eigen::Matrix3d> all;
  if (std::none_of(states.begin(), states.end(), [](const auto& state) { return state.frame != nullptr; })) return all;
  for (std::size_t b = 0; b < states.size(); ++b) {
    const auto& frame = states[b].frame;
    all.push_back(frame ? frame->fit(segment(u, b), states[b].parallel.get()).motion.rotation
                        : Eigen::Matrix3d::Identity());
  }
  return all;
}

std::vector<const fem::SparseMatrix*> CombinedParts::tangents(const Eigen::VectorXd& u) const {
  std::vector<const fem::SparseMatrix*> all;
  for (std::size_t b = 0; b < states.size(); ++b) all.push_back(&forces[b]->tangent(segment(u, b)));
  return all;
}

fem::SparseMatrix CombinedParts::block_diagonal(const std::vector<const fem::SparseMatrix*>& blocks) const {
  fem::SparseMatrix all(dofs_, dofs_);
  Eigen::Index entries = 0;
  for (const auto* block : blocks) entries += block->nonZeros();
  all.reserve(entries);
  for (std::size_t b = 0; b < states.size(); ++b) {
    for (int row = 0; row < states[b].part.dofs(); ++row) {
      const auto combined = offsets[b] + row;
      all.startVec(combined);
      for (fem::SparseMatrix::InnerIterator it(*blocks[b], row); it; ++it)
        all.insertBack(combined, offsets[b] + it.col()) = it.value();
    }
  }
  all.finalize();
  return all;
}

void CombinedParts::evaluate_moved(double dt, std::size_t part, const Eigen::VectorXd& increment,
                                   Eigen::VectorXd& force) const {
  Eigen::VectorXd moved = states[part].u + segment(increment, part);
  force.setZero(moved.size());
  forces[part]->evaluate(dt, moved, force);
}

void CombinedParts::hold(double dt, const Eigen::VectorXd& increment, Eigen::VectorXd& change) const {
  change.setZero(dofs_);
  Eigen::VectorXd own;
  for (std::size_t b = 0; b < states.size(); ++b) {
    if (forces[b]->linear()) continue;
    Eigen::VectorXd moved = states[b].u + segment(increment, b);
    own.setZero(moved.size());
    forces[b]->hold(dt, moved, own);
    segment(change, b) = own;
  }
}

void CombinedParts::let_go() const {
  for (const auto& force : forces) force->let_go();
}

bool CombinedParts::hold_enough(const Eigen::VectorXd& increment) const {
  bool enough = true;
  for (std::size_t b = 0; b < states.size() && enough; ++b) {
    if (forces[b]->linear()) continue;
    Eigen::VectorXd moved = states[b].u + segment(increment, b);
    enough = forces[b]->hold_enough(moved);
  }
  return enough;
}

void CombinedParts::settle(double dt) const {
  for (std::size_t b = 0; b < states.size(); ++b) {
    if (!forces[b]->remembers()) continue;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(states[b].part.dofs());
    forces[b]->evaluate(dt, states[b].u, force);
    forces[b]->follow(force);
    forces[b]->settle();
  }
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
    Eigen::VectorXd anew;  // where a few rows of K are not enough
    if (!forces[b]->linear() && !states[b].constrained.empty()) evaluate_moved(dt, b, trial.increment, anew);
    for (const auto& c : states[b].constrained) {
      const auto dof = static_cast<int>(offsets[b]) + c.dof;
      double internal = state.external[dof] - state.residual[dof] - state.link[dof];
      if (anew.size() > 0) {
        internal = anew[c.dof];
      } else {
        for (fem::SparseMatrix::InnerIterator it(states[b].part.stiffness, c.dof); it; ++it)
          internal += it.value() * trial.increment[offsets[b] + it.col()];
      }
      trial.velocity[dof] = c.velocity(time_s, dt);
      trial.acceleration[dof] = c.acceleration(time_s, dt);
      trial.end.residual[dof] = states[b].mass[c.dof] * trial.acceleration[dof];
      trial.end.external[dof] = trial.end.residual[dof] + internal + trial.end.link[dof];
    }
  }
}

}  // namespace ricochet::implicit_solver
