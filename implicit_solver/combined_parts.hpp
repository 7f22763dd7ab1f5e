#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/body/internal_force.hpp"
#include "common/body/linear_elements.hpp"

namespace ricochet::implicit_solver {

/// The vectors that the next window is computed from, with the motion of the bodies; combined vectors.
struct WindowState {
  Eigen::VectorXd residual;  ///< q = f - P(u) - L without the contact forces, carried along by increments [N]
  Eigen::VectorXd external;  ///< f, reactions included [N]
  Eigen::VectorXd link;      ///< L, internal force of the explicit elements at the shared nodes [N]

  void archive(Archive& a) { a(residual, external, link); }
};

/// A window as it is tried: u_{n+1} - u_n and the rates at n + 1, and what becomes the state if it is accepted.
struct WindowTrial {
  Eigen::VectorXd increment, velocity, acceleration;
  WindowState end;
};

/// Makes the internal force of a part.
using MakeForce = std::function<std::unique_ptr<solver::InternalForce>(const solver::BodyState& state)>;

/// All parts of the implicit participant one after another, in combined vectors, with what their elements answer.
class CombinedParts {
 public:
  /// `states` must outlive this object unmoved.
  explicit CombinedParts(std::vector<solver::BodyState>& states, const MakeForce& make_force = solver::linear_elements);

  [[nodiscard]] std::size_t size() const { return states.size(); }
  [[nodiscard]] Eigen::Index dofs() const { return dofs_; }
  /// Whether the internal force of every part is linear in u.
  [[nodiscard]] bool linear() const { return linear_; }
  /// Whether that of every part keeps its tangent.
  [[nodiscard]] bool keep_tangents() const { return keep_tangents_; }
  [[nodiscard]] Eigen::VectorXd displacement() const;
  /// The part of a combined number.
  [[nodiscard]] std::size_t part_of(Eigen::Index dof) const;
  /// The largest coordinate of a part in a frame, which turns with it [m]; 0 without one.
  [[nodiscard]] double turning_m(std::size_t part) const;
  /// R of the frame of each part at a displacement (PartFrame), of a part without one 1. Empty if none has a frame.
  [[nodiscard]] std::vector<Eigen::Matrix3d> rotations(const Eigen::VectorXd& u) const;
  /// K_T of each part at a displacement [N/m]; they stay until the next call.
  [[nodiscard]] std::vector<const fem::SparseMatrix*> tangents(const Eigen::VectorXd& u) const;
  /// A matrix of each part, made one matrix.
  [[nodiscard]] fem::SparseMatrix block_diagonal(const std::vector<const fem::SparseMatrix*>& blocks) const;
  [[nodiscard]] auto segment(Eigen::VectorXd& combined, std::size_t part) const {
    return combined.segment(offsets[part], states[part].part.dofs());
  }
  [[nodiscard]] auto segment(const Eigen::VectorXd& combined, std::size_t part) const {
    return combined.segment(offsets[part], states[part].part.dofs());
  }
  /// P(u_n + increment) of a part [N].
  void evaluate_moved(double dt, std::size_t part, const Eigen::VectorXd& increment, Eigen::VectorXd& force) const;
  /// See InternalForce: at u_n + increment.
  void hold(double dt, const Eigen::VectorXd& increment, Eigen::VectorXd& change) const;
  void let_go() const;
  [[nodiscard]] bool hold_enough(const Eigen::VectorXd& increment) const;
  /// Elements with a memory keep that of the accepted window, whose displacement the states have.
  void settle(double dt) const;
  /// Loads at a time into the segments of the parts that have some [N].
  void external_force(double time_s, Eigen::VectorXd& external) const;
  /// Load on a dashpot's dof: `external_force` leaves out the parts without loads.
  [[nodiscard]] double load_on(std::size_t part, int dof, const Eigen::VectorXd& external) const {
    return states[part].external.zero() ? 0.0 : external[offsets[part] + dof];
  }
  /// Motion of the constrained dofs at the window's end, and the reactions R = M a + P(u) + L - f there, which join f.
  void constrain_rates(double time_s, double dt, const WindowState& state, WindowTrial& trial) const;

  std::vector<solver::BodyState>& states;
  std::vector<std::unique_ptr<solver::InternalForce>> forces;  ///< per part
  std::vector<Eigen::Index> offsets;
  std::vector<int> shared_dofs;  ///< combined numbers, interface order

 private:
  Eigen::Index dofs_ = 0;
  bool linear_ = true, keep_tangents_ = true;
};

}  // namespace ricochet::implicit_solver
