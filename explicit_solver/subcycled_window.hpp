#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "common/body/body_state.hpp"
#include "explicit_solver/linear_force.hpp"

namespace ricochet::explicit_solver {

/// One window of central difference steps on a part whose shared nodes are integrated here, with their own mass, and
/// are driven by the interface multiplier lambda [N] of a dual protocol, linear over the window:
///   M a_j = f_j - P(u_j) + lambda_j,   lambda_j = lambda_0 + j/m (lambda_m - lambda_0),   j = 1 .. m
/// A trial with another lambda_m repeats nothing that it does not reach, where P is linear: then the motion is linear
/// in lambda, and the correction is the response to the change alone, from rest, and in m steps that response gets no
/// further than m - 1 layers of nodes:
///   M da_j = -K du_j + j/m dlambda_m
/// (Prakash, Hjelmstad: A FETI-based multi-time-step coupling method, Int. J. Numer. Meth. Engng 61, 2004, split free
/// and link problems alike). Where loads act, or dashpots within that reach, or P is not linear, the window is computed
/// anew instead.
class SubcycledWindow {
 public:
  /// `substeps`: the largest number of steps in a window; `dt` of one step [s].
  SubcycledWindow(const solver::BodyState& state, int substeps, double dt, const MakeForce& make_force = linear_force);

  /// At the present time: accelerations of `state` from its displacement and `force` (per shared dof).
  void start(solver::BodyState& state, double time_s, const Eigen::VectorXd& force);
  /// Size of one step [s], of the windows to come.
  void set_step(double dt);
  /// Trial of `steps` steps from the accepted `state` on, which began at `begin_s`; `force` at its end.
  void advance(const solver::BodyState& state, double begin_s, int steps, const Eigen::VectorXd& force);
  /// The same with the multiplier held, unless there is a trial already.
  void advance_held(const solver::BodyState& state, double begin_s, int steps);
  /// Makes the trial final: motion, external work, impulses and interface work into `state`.
  void accept(solver::BodyState& state);

  /// Motion of shared dof i (in the order of BodyState::shared_dofs) at the end of the trial.
  struct Motion {
    double displacement, velocity, acceleration;
  };
  [[nodiscard]] Motion shared_motion(const solver::BodyState& state, std::size_t i) const;
  /// With the part's motion all that the next window is computed from.
  struct State {
    Eigen::VectorXd internal, external, force;  ///< P(u); f with reactions; lambda per shared dof [N]
    std::string elements;                       ///< what the part's InternalForce keeps

    void archive(Archive& a) {
      a(internal, external, force);
      a.any_size(elements);
    }
  };
  [[nodiscard]] State state() const;
  void restore(const State& state);
  [[nodiscard]] const Eigen::VectorXd& internal() const { return accepted_.internal; }  ///< P(u) [N]
  [[nodiscard]] solver::InternalForce& elements() const { return *elements_; }

 private:
  void run(const solver::BodyState& state, double begin_s, int steps, const Eigen::VectorXd& force);
  void correct(const solver::BodyState& state, double begin_s, const Eigen::VectorXd& force);
  void clear_correction();
  [[nodiscard]] double interface_work() const;

  double dt_ = 0.0;
  std::unique_ptr<solver::InternalForce> elements_;
  State accepted_;
  // the trial that was computed in full
  bool tried_ = false;
  int steps_ = 0;
  Eigen::VectorXd u_, v_, a_, trial_internal_, trial_external_, external_old_, a_new_, trial_force_;
  Eigen::MatrixXd shared_path_;  ///< displacement of the shared dofs, a column per step, first the start
  solver::Given given_;          ///< what the surroundings did
  // its correction: dofs within reach of the shared nodes, and the part's stiffness among them
  std::vector<int> near_;                                                        ///< dofs, ascending
  std::vector<int> near_of_shared_;                                              ///< per shared dof, index into near_
  std::vector<std::pair<int, const solver::ConstrainedDof*>> near_constrained_;  ///< index into near_, and the dof
  bool near_dashpots_ = false;
  bool anything_given_ = false;  ///< of a share of a part: loads anywhere in it, or dashpots within reach
  fem::StiffnessProduct near_stiffness_;
  Eigen::VectorXd near_inverse_mass_, du_, dv_, da_, da_new_, d_internal_, d_internal_old_, d_force_;
  Eigen::MatrixXd d_shared_path_;
  solver::Given d_given_;
};

}  // namespace ricochet::explicit_solver
