#include "common/body/turning_elements.hpp"

#include <utility>

namespace ricochet::solver {

TurningElements::TurningElements(const BodyState& state, std::unique_ptr<InternalForce> elements)
    : state_(&state), elements_(std::move(elements)), all_{{0, state.part.dofs()}} {
  straining_.setZero(state.part.dofs());
  force_in_frame_.setZero(state.part.dofs());
  fit_ = state.frame->fit(state.u);
  for (int dof = 0; dof < state.part.dofs() && !spreads_; ++dof) spreads_ = elements_->spreads(dof);
}

void TurningElements::evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  Parallel* const threads = state_->parallel.get();
  if (state_->others != nullptr) state_->others->exchange(u);
  fit_ = state_->frame->fit(u, threads);
  state_->frame->straining(u, fit_.motion, straining_, threads);
  elements_->evaluate(step_s, straining_, force_in_frame_);
  state_->frame->force(fit_, straining_, force_in_frame_, force, threads);
}

double TurningElements::stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force, double) const {
  Parallel* const threads = state_->parallel.get();
  const fem::RigidMotion motion = state_->frame->fit(u, threads).motion;
  state_->frame->straining(u, motion, looked_at_, threads);
  double work_j = 0.0;
  for (int block = 0; block < blocks_of(state_->part.nodes()); ++block)
    work_j += state_->frame->work_of(motion.rotation, looked_at_, force, block);
  return elements_->stored(looked_at_, force, 0.5 * work_j);
}

const fem::SparseMatrix& TurningElements::tangent(const Eigen::VectorXd& u) {
  const fem::RigidMotion motion = state_->frame->fit(u).motion;
  tangent_ = elements_->tangent(state_->frame->straining(u));
  const int components = fem::components(state_->part.mesh.model);
  // Rows and columns come by nodes, whole: each block of a pair of nodes is turned on both sides.
  const int* const outer = tangent_.outerIndexPtr();
  double* const values = tangent_.valuePtr();
  for (int row = 0; row < state_->part.dofs(); row += components) {
    const int entries = outer[row + 1] - outer[row];
    for (int entry = 0; entry < entries; entry += components) {
      Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
      for (int c = 0; c < components; ++c) {
        for (int d = 0; d < components; ++d) block(c, d) = values[outer[row + c] + entry + d];
      }
      block = motion.rotation * block * motion.rotation.transpose();
      for (int c = 0; c < components; ++c) {
        for (int d = 0; d < components; ++d) values[outer[row + c] + entry + d] = block(c, d);
      }
    }
  }
  return tangent_;
}

/// S keeps the moment of a force about where the part began, but not about where the part is. The part as a whole takes
/// the difference, as in PartFrame::force.
void TurningElements::spread(Eigen::VectorXd& force) {
  if (!spreads_) return;
  in_frame_ = force;
  turn_nodes(fit_.motion.rotation.transpose(), fem::components(state_->part.mesh.model), in_frame_);
  change_ = in_frame_;
  elements_->spread(change_);
  change_ -= in_frame_;
  state_->frame->force(fit_, straining_, change_, in_frame_, state_->parallel.get());
  force += in_frame_;
}

/// d . g = d . R^T P, as in `stored`.
InternalForce::Unspread TurningElements::unspread(const Eigen::VectorXd& u, const Eigen::VectorXd& force) {
  if (!spreads_) return {};
  const fem::RigidMotion motion = state_->frame->fit(u).motion;
  Eigen::VectorXd d, in_frame = force;
  state_->frame->straining(u, motion, d);
  turn_nodes(motion.rotation.transpose(), fem::components(state_->part.mesh.model), in_frame);
  return elements_->unspread(d, in_frame);
}

void TurningElements::archive(Archive& a) {
  elements_->archive(a);
  if (!a.reading()) return;
  fit_ = state_->frame->fit(state_->u);
  state_->frame->straining(state_->u, fit_.motion, straining_);
}

}  // namespace ricochet::solver
