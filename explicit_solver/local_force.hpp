#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/fem/local_steps.hpp"
#include "explicit_solver/material_force.hpp"

namespace ricochet::explicit_solver {

/// S P(u) of a part that steps locally (fem::LocalSteps), of elements that are linear or yield. S is that of K, the
/// largest stiffness that yielding elements have. Nobody else shares the nodes of the part.
class LocalForce final : public solver::InternalForce {
 public:
  /// As material_force. Rows that step locally are computed from the start on.
  LocalForce(const solver::BodyState& state, const std::vector<int>& driven, double window_s);

  void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void follow(const Eigen::VectorXd& force) override { elements_->follow(force); }
  void settle() override { elements_->settle(); }
  void go_back() override { elements_->go_back(); }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return elements_->rows(); }
  void reach_all() override { elements_->reach_all(); }
  void spread(Eigen::VectorXd& force) override { steps_.spread(force); }
  [[nodiscard]] bool spreads(int dof) const override;
  [[nodiscard]] bool linear() const override { return elements_->linear(); }
  /// Of the elements at u, which is u . P(u)/2 and not u . S P(u)/2.
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                              double half_work_j) const override;
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override { return elements_->tangent(u); }
  void archive(Archive& a) override { elements_->archive(a); }

 private:
  const solver::BodyState* state_;
  fem::LocalSteps steps_;
  std::unique_ptr<solver::InternalForce> elements_;
};

/// Of windows of one size.
[[nodiscard]] MakeForce local_force(double window_s);

}  // namespace ricochet::explicit_solver
