#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/solver/body_state.hpp"

namespace ricochet::implicit_solver {

/// What the next window is computed from, with the motion of the bodies; combined vectors.
struct WindowState {
  Eigen::VectorXd residual;  ///< q = f - K u - L without the contact forces, carried along by increments [N]
  Eigen::VectorXd external;  ///< f, reactions included [N]
  Eigen::VectorXd link;      ///< L, internal force of the explicit elements at the shared nodes [N]

  void archive(Archive& a) { a(residual, external, link); }
};

/// A window as it is tried: u_{n+1} - u_n and the rates at n + 1, and what becomes the state if it is accepted.
struct WindowTrial {
  Eigen::VectorXd increment, velocity, acceleration;
  WindowState end;
};

/// All parts of the implicit participant one after another, in combined vectors.
class CombinedParts {
 public:
  /// `states` must outlive this object unmoved.
  explicit CombinedParts(std::vector<solver::BodyState>& states);

  [[nodiscard]] std::size_t size() const { return states.size(); }
  [[nodiscard]] Eigen::Index dofs() const { return dofs_; }
  /// K of all parts, block diagonal, made anew [N/m].
  [[nodiscard]] fem::SparseMatrix stiffness() const;
  [[nodiscard]] auto segment(Eigen::VectorXd& combined, std::size_t part) const {
    return combined.segment(offsets[part], states[part].part.dofs());
  }
  [[nodiscard]] auto segment(const Eigen::VectorXd& combined, std::size_t part) const {
    return combined.segment(offsets[part], states[part].part.dofs());
  }
  /// Loads at a time into the segments of the parts that have some [N].
  void external_force(double time_s, Eigen::VectorXd& external) const;
  /// Load on a dashpot's dof: `external_force` leaves out the parts without loads.
  [[nodiscard]] double load_on(std::size_t part, int dof, const Eigen::VectorXd& external) const {
    return states[part].external.zero() ? 0.0 : external[offsets[part] + dof];
  }
  /// Motion of the constrained dofs at the window's end, and the reactions R = M a + K u + L - f there, which join f.
  void constrain_rates(double time_s, double dt, const WindowState& state, WindowTrial& trial) const;

  std::vector<solver::BodyState>& states;
  std::vector<Eigen::Index> offsets;
  std::vector<int> shared_dofs;  ///< combined numbers, interface order

 private:
  Eigen::Index dofs_ = 0;
};

}  // namespace ricochet::implicit_solver
