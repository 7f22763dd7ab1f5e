#pragma once

#include <Eigen/Core>
#include <vector>

#include "coupler/interface/coupling.hpp"

namespace ricochet::coupler {

/// Common to the dual protocols: duplicated nodes with own masses, tied by an interface multiplier lambda [N] (on the
/// explicit side; the implicit side feels -lambda) so that velocities agree at the end of a step:
///   Pi v_implicit = v_explicit,   v_explicit = v_free + H (lambda - lambda_held)
/// v_free: velocity with lambda held from the start of the step; H [m/s/N]: interface operator of an explicit
/// participant, the velocity at the end of the step per unit multiplier there, from unit responses at the start.
///
/// The implicit participant solves for the multiplier and its contact forces together: with Z = H^-1,
///   lambda = lambda_held + Z (v - v_free),   v = 2/dt (u - u_n) - v_n  (trapezoidal rule)
/// is a stiffness S = 2/dt Z in its operator and a force on its right-hand side. That is the condensed form of the
/// dense problem for (lambda, contact forces); nothing is iterated between the two, and whatever the contact does the
/// velocities agree. The operator goes this way, explicit to implicit, because only the implicit side knows the contact
/// laws.
///
/// Several explicit participants may meet at a node; each has its own multiplier, Z adds up.
class DualInterface {
 public:
  /// Initialises everyone with its own masses, measures the operators by one `probe` step each, chooses the multipliers
  /// at t = 0 so that accelerations agree there, and synchronises. Throws ConfigError for a participant without mass at
  /// an interface node or with an operator that is not positive definite.
  void start(Coupling& coupling, const wire::Initialize& request, const Step& probe);

  /// Between windows of different sizes: measures the operators of the windows to come.
  void reconfigure(Coupling& coupling, const Step& probe);
  /// The operators, where they are not those of the start any more.
  void archive(Archive& a);

  /// Trial of all explicit participants with the multipliers held; finds v_free.
  void advance_free(const Step& step);
  /// The forces that the implicit participant is to be given after `advance_free`, shared numbering [N]:
  /// lambda_held - Z (v_free + v_n) - S u_n.
  [[nodiscard]] const std::vector<double>& held_force(const Coupling& coupling);
  /// lambda = lambda_held + Z (v - v_free) for all explicit participants, which accept it. `velocity`: of the shared
  /// nodes.
  void correct(const Step& step, const std::vector<double>& velocity);

  [[nodiscard]] bool reconfigured() const { return reconfigured_; }
  /// Z of all explicit participants, and lambda_held - Z v_free [N]; shared numbering.
  [[nodiscard]] const Eigen::MatrixXd& impedance() const { return impedance_; }
  [[nodiscard]] const Eigen::VectorXd& held() const { return held_; }
  /// Sum of the multipliers at the last accepted step [N].
  [[nodiscard]] Eigen::VectorXd multiplier() const;

 private:
  struct Side {
    Link* link;                 ///< its accepted input is the multiplier
    Eigen::MatrixXd impedance;  ///< Z, own rows; zero where the response is (supports)
    Eigen::VectorXd free_velocity;
    std::vector<double> acceleration;        ///< at t = 0, without multiplier
    Eigen::VectorXd jump, force;             ///< v - v_free, Z times a velocity: kept so that no window allocates
    std::vector<double> common, multiplier;  ///< Pi v of the shared nodes, and the same
  };
  void measure(Side& side, const Step& probe, double step_s);
  [[nodiscard]] double step_s(const Coupling& coupling, const Step& probe) const;
  [[nodiscard]] Eigen::MatrixXd stiffness(const Coupling& coupling) const;
  void start_multipliers(Coupling& coupling);
  std::vector<Side> sides_;
  Eigen::MatrixXd impedance_;
  Eigen::VectorXd held_;
  std::vector<double> force_;
  int substeps_ = 1;
  bool reconfigured_ = false;
};

}  // namespace ricochet::coupler
