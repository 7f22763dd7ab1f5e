#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"
#include "common/body/part_frame.hpp"

namespace ricochet::solver {

/// P of elements whose part turns by any angle: in a frame that turns with the part (PartFrame) they answer to what is
/// left there of its motion. Strain and rotation relative to the frame must be small. P is the gradient of their
/// energy, so that central difference keeps the angular momentum to rounding and the energy as that of a linear part.
class TurningElements final : public InternalForce {
 public:
  /// `elements`: those in the frame. `state`, whose frame is not null, must outlive this object unmoved.
  TurningElements(const BodyState& state, std::unique_ptr<InternalForce> elements);

  void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) override;
  void follow(const Eigen::VectorXd&) override { elements_->follow(force_in_frame_); }
  [[nodiscard]] bool remembers() const override { return elements_->remembers(); }
  void settle() override { elements_->settle(); }
  void go_back() override { elements_->go_back(); }
  [[nodiscard]] const std::vector<Rows>& rows() const override { return all_; }
  [[nodiscard]] bool linear() const override { return false; }
  [[nodiscard]] double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                              double half_work_j) const override;
  /// R K R^T, without what the turn of the frame adds where the part is under stress.
  [[nodiscard]] const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) override;
  /// R S R^T f, but for what that changes of its moment: the small steps are those of elements in the frame.
  void spread(Eigen::VectorXd& force) override;
  [[nodiscard]] bool spreads(int dof) const override { return elements_->spreads(dof); }
  [[nodiscard]] const Eigen::Matrix3d* turn() const override { return spreads_ ? &fit_.motion.rotation : nullptr; }
  [[nodiscard]] Unspread unspread(const Eigen::VectorXd& u, const Eigen::VectorXd& force) override;
  void archive(Archive& a) override;

 private:
  const BodyState* state_;
  std::unique_ptr<InternalForce> elements_;
  std::vector<Rows> all_;
  bool spreads_ = false;                        ///< some of the elements step locally
  PartFrame::Fit fit_;                          ///< of the last evaluation
  Eigen::VectorXd straining_, force_in_frame_;  ///< d and g of it
  Eigen::VectorXd in_frame_, change_;           ///< of `spread`, kept so that no window allocates
  mutable Eigen::VectorXd looked_at_;           ///< d of `stored`, kept so that no window allocates
  fem::SparseMatrix tangent_;
};

}  // namespace ricochet::solver
