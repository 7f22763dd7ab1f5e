#include "common/body/turning_elements.hpp"

#include <utility>

namespace ricochet::solver {

TurningElements::TurningElements(const BodyState& state, std::unique_ptr<InternalForce> elements)
    : state_(&state), elements_(std::move(elements)), all_{{0, state.part.dofs()}} {
  straining_.setZero(state.part.dofs());
  force_in_frame_.setZero(state.part.dofs());
}

void TurningElements::evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  Parallel* const threads = state_->parallel.get();
  const auto fit = state_->frame->fit(u, threads);
  state_->frame->straining(u, fit.motion, straining_, threads);
  elements_->evaluate(step_s, straining_, force_in_frame_);
  state_->frame->force(fit, straining_, force_in_frame_, force, threads);
}

/// d . g/2 = sum of (R d_i) . P_i/2, since sum m_i Y_i x d_i = 0.
double TurningElements::stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force, double) const {
  const fem::RigidMotion motion = state_->frame->fit(u).motion;
  Eigen::VectorXd d;
  state_->frame->straining(u, motion, d);
  const int components = fem::components(state_->part.mesh.model);
  double work_j = 0.0;
  for (int dof = 0; dof < d.size(); dof += components) {
    Eigen::Vector3d strained = Eigen::Vector3d::Zero(), pulled = strained;
    for (int c = 0; c < components; ++c) {
      strained[c] = d[dof + c];
      pulled[c] = force[dof + c];
    }
    work_j += (motion.rotation * strained).dot(pulled);
  }
  return elements_->stored(d, force, 0.5 * work_j);
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

}  // namespace ricochet::solver
