#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/fem/local_steps.hpp"
#include "explicit_solver/linear_force.hpp"

namespace ricochet::explicit_solver {

/// P = K~u of a part that steps locally (fem::LocalSteps): S K u. Nobody else shares its nodes.
class LocalForce final : public solver::LinearElements {
 public:
  /// As LinearForce. Rows that step locally are computed from the start on.
  LocalForce(const solver::BodyState& state, const std::vector<int>& driven, double window_s);

  void evaluate(double, Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void follow(const Eigen::VectorXd& force) override { front_.grow(force); }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return front_.rows(); }
  void reach_all() override { front_.reach_all(); }
  void spread(Eigen::VectorXd& force) override { steps_.spread(force); }
  [[nodiscard]] bool spreads(int dof) const override;
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                              double half_work_j) const override;
  void archive(Archive& a) override { front_.archive(a); }

 private:
  fem::LocalSteps steps_;
  WaveFront front_;
};

/// Of windows of one size.
[[nodiscard]] MakeForce local_force(double window_s);

}  // namespace ricochet::explicit_solver
