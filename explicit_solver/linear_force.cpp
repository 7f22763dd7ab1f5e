#include "explicit_solver/linear_force.hpp"

namespace ricochet::explicit_solver {

LinearForce::LinearForce(const solver::BodyState& state, const std::vector<int>& driven)
    : LinearElements(state), front_(state, driven) {
  set_shared_columns();
}

void LinearForce::set_shared_columns() {
  const auto& stiffness = state_->part.stiffness;
  std::vector<int> column(static_cast<std::size_t>(state_->part.dofs()), -1);
  for (std::size_t i = 0; i < state_->shared_dofs.size(); ++i)
    column[static_cast<std::size_t>(state_->shared_dofs[i])] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < state_->part.dofs(); ++row) {
    const auto before = entries.size();
    for (fem::SparseMatrix::InnerIterator it(stiffness, row); it; ++it) {
      const int place = column[static_cast<std::size_t>(it.col())];
      if (place >= 0) entries.emplace_back(static_cast<int>(near_rows_.size()), place, it.value());
    }
    if (entries.size() > before) near_rows_.push_back(row);
  }
  const auto rows = static_cast<Eigen::Index>(near_rows_.size()),
             columns = static_cast<Eigen::Index>(state_->shared_dofs.size());
  shared_columns_.resize(rows, columns);
  shared_columns_.setFromTriplets(entries.begin(), entries.end());
  near_before_.setZero(rows);
  shared_before_.setZero(columns);
  shared_moved_.setZero(columns);
}

void LinearForce::before_link(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  evaluate(step_s, u, force);
  for (std::size_t i = 0; i < near_rows_.size(); ++i) near_before_[static_cast<Eigen::Index>(i)] = force[near_rows_[i]];
  for (Eigen::Index i = 0; i < shared_before_.size(); ++i)
    shared_before_[i] = u[state_->shared_dofs[static_cast<std::size_t>(i)]];
}

void LinearForce::after_link(double, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  for (Eigen::Index i = 0; i < shared_before_.size(); ++i)
    shared_moved_[i] = u[state_->shared_dofs[static_cast<std::size_t>(i)]] - shared_before_[i];
  for (std::size_t i = 0; i < near_rows_.size(); ++i) {
    const auto row = static_cast<int>(i);
    double sum = near_before_[row];
    for (fem::SparseMatrix::InnerIterator it(shared_columns_, row); it; ++it)
      sum += it.value() * shared_moved_[it.col()];
    force[near_rows_[i]] = sum;
  }
}

std::unique_ptr<solver::InternalForce> linear_force(const solver::BodyState& state, const std::vector<int>& driven) {
  return std::make_unique<LinearForce>(state, driven);
}

}  // namespace ricochet::explicit_solver
