#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/solver/contact_surface.hpp"
#include "implicit_solver/contact/root_problem.hpp"

namespace ricochet::implicit_solver {

/// Contact of the implicit side: kinematics of the pairs, the root problem, the update of velocities and accelerations on
/// the contact surface, and the work of the contact forces.
///
/// The window's equation is A du = b + kappa dt^2/4 G^T r. kappa = 2 and r not remembered is the fully implicit law (Kane et al.):
///   u_{n+1} = u_n + dt v_n + dt^2/4 (a_n + a_{n+1}) + dt^2/2 M^-1 G^T r,   v_{n+1} = v_n + dt/2 (a_n + a_{n+1}) + dt M^-1 G^T r
/// with a the elastic acceleration. kappa = 1 lets r enter as any force of n + 1; afterwards velocity and acceleration of
/// every closed pair are set to a weighted mean (Eq. 25), by masses (conserves momentum) or impedances (the paper's). Or the nodes
/// have no mass along the normal: then no velocity has to jump, r balances K u at any time, and the impact of a node costs nothing.
class ImplicitContact {
 public:
  ImplicitContact(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts,
                  const std::vector<solver::BodyState>& states);

  /// Degrees of freedom (combined numbering: offsets[part] + local dof) the contact acts on, constrained ones left out.
  [[nodiscard]] const std::vector<int>& root_dofs() const { return root_dofs_; }
  /// Sets up the root problem from S^-1 on the root dofs.
  void prepare(const Eigen::MatrixXd& root_inverse, double dt);

  /// kappa of the class comment.
  [[nodiscard]] double kappa() const;
  /// Whether r is remembered in the acceleration (not by the fully implicit law).
  [[nodiscard]] bool remembered() const { return kappa() == 1.0; }

  /// Whether contact nodes have no mass along the normal.
  [[nodiscard]] bool massless() const;
  /// Moves the mass of every contact node along the normal to its neighbours one layer of elements inwards.
  void move_masses(std::vector<solver::BodyState>& states) const;

  /// Finds the contact forces of the window that is being tried. `increment` holds the free increments at contact dofs
  /// (combined numbering); on return root_force() holds G^T r per root dof.
  void solve(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment);
  [[nodiscard]] const Eigen::VectorXd& root_force() const { return root_force_; }
  /// Sets velocity and acceleration of closed pairs of the trial (combined vectors) to the mean the scene asks for.
  void update_rates(const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration);
  /// Accounts work and impulse of the window: `bracket` = (M a_n - q_n) + (M a*_{n+1} - q_{n+1}) at the root dofs, the contact
  /// forces in the trapezoidal sum; `jump` = M (v - v*) of update_rates, `mean_velocity` = (v + v*)/2 there; combined vectors.
  void account(std::vector<solver::BodyState>& states, const Eigen::VectorXd& bracket, const Eigen::VectorXd& increment,
               const Eigen::VectorXd& jump, const Eigen::VectorXd& mean_velocity, double dt);
  void accept() { accepted_ = trial_; }
  /// Drops all contact forces (after the switch to explicit integration).
  void open() { accepted_ = trial_ = root_->open(); }

  /// From here on no contact force, or every pair held at zero gap (and, with friction, zero slip), in tension, too.
  void freeze(participant::FrozenContact frozen) { frozen_ = frozen; }
  [[nodiscard]] bool held() const { return frozen_ == participant::FrozenContact::sticking; }
  /// Held pairs: what the law makes of velocity and elastic acceleration (combined vectors) of the present motion.
  void hold_rates(const std::vector<solver::BodyState>& states, Eigen::VectorXd& velocity, Eigen::VectorXd& acceleration);

  [[nodiscard]] solver::Report report(const std::vector<solver::BodyState>& states);
  [[nodiscard]] int pairs_closed() const;
  [[nodiscard]] const solver::ContactSurface& surface() const { return surface_; }

 private:
  struct Mean {
    double share_a, share_b;  ///< A moves by share_a * (x_B - x_A), B by -share_b * (x_B - x_A)
  };
  [[nodiscard]] Mean mean_shares(const solver::Pair& pair, const std::vector<solver::BodyState>& states,
                                 const Eigen::Vector2d& direction) const;
  void set_mean(const solver::Pair& pair, const std::vector<solver::BodyState>& states, const Eigen::Vector2d& direction,
                Eigen::VectorXd& values) const;
  void find_moved(const std::vector<solver::BodyState>& states, const Eigen::VectorXd& increment);
  [[nodiscard]] double combined(const solver::Pair& pair, const Eigen::VectorXd& values, const Eigen::Vector2d& direction) const;

  const scene::Problem* problem_;  ///< materials for the impedances
  const scene::Contact* law_;
  solver::ContactSurface surface_;
  std::optional<participant::FrozenContact> frozen_;
  std::vector<int> offsets_;
  std::vector<int> root_dofs_;
  Eigen::MatrixXd gather_;            ///< G: relative motion per root motion, rows as the unknowns of RootProblem
  std::optional<RootProblem> root_;
  Eigen::VectorXd gap_free_, slip_free_, slip_velocity_, root_force_;
  RootProblem::Solution trial_, accepted_;
  std::vector<solver::PairForce> reported_;  ///< kept so that no record allocates
  double work_normal_j_ = 0.0, dissipated_friction_j_ = 0.0;
};

}  // namespace ricochet::implicit_solver
