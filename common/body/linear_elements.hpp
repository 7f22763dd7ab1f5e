#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"

namespace ricochet::solver {

/// P = K u of a part, in all rows.
class LinearElements : public InternalForce {
 public:
  /// `state` must outlive this object unmoved.
  explicit LinearElements(const BodyState& state) : state_(&state), all_{{0, state.part.dofs()}} {}

  void evaluate(double, Eigen::VectorXd& u, Eigen::VectorXd& force) override { state_->stiffness.multiply(u, force); }
  [[nodiscard]] const std::vector<Rows>& rows() const override { return all_; }
  [[nodiscard]] bool linear() const final { return true; }
  [[nodiscard]] double stored(const Eigen::VectorXd&, const Eigen::VectorXd&, double half_work_j) const override {
    return half_work_j;
  }
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd&) final { return state_->part.stiffness; }

 protected:
  const BodyState* state_;

 private:
  std::vector<Rows> all_;
};

[[nodiscard]] inline std::unique_ptr<InternalForce> linear_elements(const BodyState& state) {
  return std::make_unique<LinearElements>(state);
}

}  // namespace ricochet::solver
