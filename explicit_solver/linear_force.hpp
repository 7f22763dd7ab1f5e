#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"
#include "common/body/linear_elements.hpp"
#include "explicit_solver/wave_front.hpp"

namespace ricochet::explicit_solver {

/// P = K u of a part, in the rows that a wave can have reached. After the link, the rows of K next to the shared nodes
/// take what their motion changes: P += K_near,shared (u_shared - u_shared before).
class LinearForce final : public solver::LinearElements {
 public:
  /// `state` before the first window; it must outlive this object unmoved. `driven`: see WaveFront.
  LinearForce(const solver::BodyState& state, const std::vector<int>& driven);

  void evaluate(double, Eigen::VectorXd& u, Eigen::VectorXd& force) override { front_.multiply(*state_, u, force); }
  void before_link(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void after_link(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void follow(const Eigen::VectorXd& force) override { front_.grow(force); }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return front_.rows(); }
  void reach_all() override { front_.reach_all(); }
  void archive(Archive& a) override { front_.archive(a); }

 private:
  void set_shared_columns();

  WaveFront front_;
  std::vector<int> near_rows_;
  fem::SparseMatrix shared_columns_;  ///< K: near rows x shared degrees of freedom
  Eigen::VectorXd near_before_, shared_before_,
      shared_moved_;  ///< P in the near rows, and u_shared, before the link; by how much it has moved
};

/// Makes the internal force of a part; `driven`: its nodes that an interface or a contact moves.
using MakeForce = std::function<std::unique_ptr<solver::InternalForce>(const solver::BodyState& state,
                                                                       const std::vector<int>& driven)>;
[[nodiscard]] std::unique_ptr<solver::InternalForce> linear_force(const solver::BodyState& state,
                                                                  const std::vector<int>& driven);

}  // namespace ricochet::explicit_solver
