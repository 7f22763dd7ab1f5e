#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"
#include "common/fem/local_steps.hpp"

namespace ricochet::explicit_solver {

/// S P(u) of a part that steps locally (fem::LocalSteps), of elements that are linear or yield. S is that of K, the
/// largest stiffness that yielding elements have. Nodes that others share take no small step. In the frame of a part
/// that turns u is what strains it.
class LocalForce final : public solver::InternalForce {
 public:
  /// `elements`: of `state`, which must outlive this object unmoved; they compute all rows that step locally.
  LocalForce(const solver::BodyState& state, std::unique_ptr<solver::InternalForce> elements, fem::LocalSteps steps);

  void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void follow(const Eigen::VectorXd& force) override { elements_->follow(force); }
  void settle() override;
  void go_back() override { elements_->go_back(); }
  [[nodiscard]] const std::vector<solver::Rows>& rows() const override { return elements_->rows(); }
  void reach_all() override { elements_->reach_all(); }
  void spread(Eigen::VectorXd& force) override { steps_.spread(force); }
  [[nodiscard]] bool spreads(int dof) const override;
  [[nodiscard]] bool linear() const override { return elements_->linear(); }
  /// Central difference with S P keeps 1/2 v . M v + 1/2 u . S K u. With the force F of plastic strain, P = K u - F,
  /// the energy of the elements and their plastic work are more than that, but for what the run begins with, by
  ///   1/2 u . (1 - S) K u - u . (1 - S) F + sum over windows of 1/2 (u_n + u_n+1) . (1 - S) (F_n+1 - F_n).
  [[nodiscard]] Unspread unspread(const Eigen::VectorXd& u, const Eigen::VectorXd& force) override;
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                              double half_work_j) const override {
    return elements_->stored(u, force, half_work_j);
  }
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override { return elements_->tangent(u); }
  void archive(Archive& a) override;

 private:
  /// The flow of elements that yield.
  struct Flow {
    double work_j = 0.0;                 ///< the sum over windows
    double plastic_work_j = 0.0;         ///< PlasticState::work_j of the last window
    Eigen::VectorXd u, u_before, force;  ///< of the last evaluation; of the last window; F of it
  };
  void note_flow();
  /// a . b in the rows that S changes, one after another: in all others what is asked for is zero.
  [[nodiscard]] double over_reached(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  [[nodiscard]] Eigen::VectorXd straining() const;

  const solver::BodyState* state_;
  fem::LocalSteps steps_;
  std::unique_ptr<solver::InternalForce> elements_;
  std::optional<Flow> flow_;
  double start_j_ = 0.0;  ///< 1/2 u . (1 - S) K u of the motion that the run begins with
};

/// A LocalForce by the material of the part and its body: of one that turns in solver::TurningElements. `driven`: see
/// WaveFront. Ranks of one participant all need it, also those without a small step: it answers after the link.
[[nodiscard]] std::unique_ptr<solver::InternalForce> local_force(const solver::BodyState& state,
                                                                 const std::vector<int>& driven, fem::LocalSteps steps);

}  // namespace ricochet::explicit_solver
