#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "common/base/archive.hpp"
#include "common/body/body_state.hpp"
#include "explicit_solver/reduced/lowest_modes.hpp"

namespace ricochet::explicit_solver {

/// A body's part as its lowest modes, phi with M, and the flexibility R of all others (MacNeal 1971; without mass at
/// the boundary: Monjaraz-Tec, Gross and Krack 2022). With B what brings forces P [N] to the shared degrees of freedom
/// and u_b their displacement [m],
///   u = sum phi q + R B P,   q'' + omega^2 q = phi^T B P,   u_b = B^T u,
/// so that the shared nodes have no mass of this part: all of it is in the modes, those of rigid motion among them. The
/// trapezoidal rule takes q to the end of a window of dt, whose P then follows from u_b there by one symmetric positive
/// definite matrix,
///   P = D (u_b - phi_b q*),   D^-1 = B^T R B + phi_b A phi_b^T,   A = diag((dt^2/4)/(1 + omega^2 dt^2/4)),
/// q* what q becomes without P at the end. There is no critical step; both momenta and, with an interface stiffness
/// D in the operator of the implicit side (belytschko_mullen), the energy stay what they are.
class ReducedPart {
 public:
  /// `state` must outlive it unmoved. Supports at shared nodes are the implicit participant's: here they are free.
  /// `probed`: the degrees of freedom that `write_probed` writes.
  /// ConfigError if there are not enough degrees of freedom for so many modes.
  ReducedPart(const solver::BodyState& state, int modes, std::vector<int> probed);

  [[nodiscard]] Eigen::Index modes() const { return lowest_.count(); }
  [[nodiscard]] const Eigen::VectorXd& omega_squared() const { return lowest_.omega_squared(); }  ///< [1/s^2]
  void set_step(double dt);
  /// P for this displacement of the shared degrees of freedom at the present time [N].
  void synchronise(const Eigen::VectorXd& u_b);
  /// A trial from the accepted motion.
  void advance(const Eigen::VectorXd& u_b);
  /// Books the window as well.
  void accept(BodyTotals& totals);

  /// P of the trial or of the accepted window, on the shared degrees of freedom in their order [N].
  [[nodiscard]] const Eigen::VectorXd& answer(bool of_trial) const { return of_trial ? trial_.force : motion_.force; }
  /// Energies, momenta and mass.
  void set_totals(BodyTotals& totals) const;
  /// Motion of every node; the velocity and acceleration are those of the modes.
  void write_motion(solver::BodyState& state) const;
  /// The same of probed degrees of freedom alone, for which it takes no solve.
  void write_probed(solver::BodyState& state) const;

  struct Motion {
    Eigen::VectorXd q, rate;   ///< of the modes [m kg^1/2, m kg^1/2/s]
    Eigen::VectorXd force, u;  ///< P and u_b [N, m]

    void archive(Archive& a) { a(q, rate, force, u); }
  };
  [[nodiscard]] const Motion& motion() const { return motion_; }
  void restore(const Motion& motion) { motion_ = motion; }
  /// At rest but for these modes; `synchronise` finds the force.
  void load(const Eigen::VectorXd& q, const Eigen::VectorXd& rate);

 private:
  [[nodiscard]] Eigen::MatrixXd at_shared(const Eigen::MatrixXd& u) const;
  void set_momenta();
  /// `force` and `moved`: per support, and of `moved` per component of its node, what each of q and P makes of them.
  void set_supports(const Eigen::MatrixXd& force, const Eigen::MatrixXd& moved);
  void book_supports(BodyTotals& totals) const;
  [[nodiscard]] Eigen::VectorXd acceleration(const Motion& motion) const;

  /// Sums over supports, of q and P one after the other.
  struct Supports {
    Eigen::MatrixXd force;   ///< x 3: the sum of their forces along x, y, z
    Eigen::MatrixXd moment;  ///< x 3: of their moments, where they act in the reference
    /// y = seen^T P: what of P moves or loads a support at all. Per axis of ReducedPart::products_ the moment that the
    /// displacement of supports adds, of q and y one after the other.
    Eigen::MatrixXd seen;
    std::vector<Eigen::MatrixXd> moved;
  };

  const solver::BodyState& state_;
  LowestModes lowest_;
  Eigen::MatrixXd at_boundary_;       ///< phi_b: shared degrees of freedom x modes
  Eigen::MatrixXd flexibility_;       ///< B^T R B [m/N]
  Eigen::LLT<Eigen::MatrixXd> rest_;  ///< of it
  Eigen::MatrixXd stiffness_;         ///< D [N/m]
  Eigen::VectorXd share_;             ///< A [s^2]
  double dt_ = 0.0;
  double mass_kg_ = 0.0;
  Eigen::MatrixXd momentum_;               ///< modes x 3: of a rate along x, y, z
  Eigen::MatrixXd moment_;                 ///< modes x 3: the moment of it where the nodes are in the reference
  std::vector<Eigen::MatrixXd> products_;  ///< modes x modes, per axis of a moment: of q and rate; none without one
  Supports supports_;
  std::vector<int> probed_;      ///< degrees of freedom
  Eigen::MatrixXd probed_of_z_;  ///< their displacement, of q and P one after the other
  Motion motion_, trial_;
};

}  // namespace ricochet::explicit_solver
