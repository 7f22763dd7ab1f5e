#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "common/base/archive.hpp"
#include "common/scene/scene.hpp"
#include "common/solver/compliance.hpp"
#include "common/solver/contact_record.hpp"

namespace ricochet::solver {

/// The contact problem of one window. Unknowns: normal force lambda_i >= 0 on B along +n and, with
/// friction, tangential force tau_i on B along +t [N], of solids along the binormal, too. Ordering: all normals, then
/// all along t, then all along the binormal.
///   gap_i  = gap_free_i  + (D x)_i          [m]   gap at n + 1
///   slip_i = slip_free_i + (D x)_{n+i}      [m]   slip increment of the window; of solids two components
/// multiplier: lambda >= 0, gap >= 0, lambda gap = 0.         penalty: lambda = alpha w max(0, -gap) (Eq. 8-10)
/// return mapping: |tau| <= mu lambda; stick: slip = 0 (penalty: tau = tau_n - alpha w slip); slip: tau = s mu lambda
/// with s opposing the slip (Eq. 21-24).                            regularised: tau = -mu lambda tanh(xi v_t) (Eq. 14,
/// 15), with v_t = 2 slip / dt - v_t,n the relative tangential velocity at n + 1.
/// Of solids tau and slip are vectors and the cone is circular: |tau| <= mu lambda; stick: slip = 0; slip: |tau| = mu
/// lambda, tau = -eta slip, eta >= 0; regularised: tau = -mu lambda tanh(xi |v_t|) v_t/|v_t|.
///
/// States are found by the criteria (17)-(24), starting from those of the last window. With a dense D the matrix of a
/// set of states is kept factored while the states do not change; with one that is sparse or only multiplies, BiCGSTAB
/// (van der Vorst 1992) solves, starting from the forces of the last window. Where states cycle (1 to 16 % of
/// frictional problems drawn at random), projected Gauss-Seidel goes on (Jacobi without rows of D), which treats both
/// friction laws; where that does not converge, Lemke's method on the linear complementarity problem that Coulomb
/// friction is in two dimensions (Lemke 1965; Klarbring 1986), for a dense D. What is left undone stands in
/// Solution::residual.
/// Of solids the criteria are those of tau = P(tau - rho slip), P the projection to the cone's disc: inside it the pair
/// sticks. The rows of a slipping pair turn with its slip, so that the iteration is a semismooth Newton method (Alart,
/// Curnier 1991), and the last resort is another start of it from what the sweeps have reached (root_cone.cpp).
class RootProblem {
 public:
  /// What is a pair's own: w and mu.
  struct PairLaw {
    double area_m2 = 0.0;
    double friction_coefficient = 0.0;
  };
  /// `compliance` D, n x n without friction, 2n x 2n with, of solids 3n x 3n; then it has the rows of pairs without
  /// friction, too, which have no forces there. `law`: all but its mu.
  RootProblem(const scene::Contact& law, Compliance compliance, std::vector<PairLaw> pairs, double dt);

  struct Solution {
    Eigen::VectorXd force;             ///< x of the class comment
    std::vector<ContactState> states;  ///< per pair
    int iterations = 0;                ///< linear solves, sweeps and pivots
    /// Largest violation of the conditions above, each as the change of force that would mend it alone, relative to the
    /// largest normal force.
    double residual = 0.0;

    void archive(Archive& a) { a(force, states, iterations, residual); }
  };

  /// `slip_free` and `slip_velocity` (v_t,n [m/s]), of solids all along t first, are ignored without friction. `last`
  /// is the accepted solution of the window before (states to start from, tangential forces of the penalty law).
  const Solution& solve(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                        const Eigen::VectorXd& slip_velocity, const Solution& last);

  /// Every pair closed and, with friction, sticking, whatever the sign of its force: the linear problem gap = 0, slip =
  /// 0 (penalty: of springs). Here `slip_free` counts from zero, not from the window before.
  const Solution& hold(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free);
  /// The state of `hold` with the penalty springs' forces at this gap and slip; multiplier: no forces.
  const Solution& spring(const Eigen::VectorXd& gap, const Eigen::VectorXd& slip);

  [[nodiscard]] Solution open() const;  ///< all pairs open, no force
  [[nodiscard]] bool friction() const { return friction_; }
  [[nodiscard]] int pairs() const { return pairs_; }

 private:
  enum class Tangent : char { none, stick, slip_plus, slip_minus, slip, regularised };  ///< slip: of a solid
  struct PairState {
    bool closed = false;
    Tangent tangent = Tangent::none;
    bool operator==(const PairState&) const = default;
  };
  /// Of a solid's closed pair: own tau + of_slip (D x)_t + of_normal lambda = rhs, without units or in N.
  struct ConeRows {
    Eigen::Matrix2d own, of_slip;
    Eigen::Vector2d of_normal, rhs;
  };
  void start_from(const Solution& last);
  /// Leaves D x of the forces in `motion_`.
  void find_states(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                   const Eigen::VectorXd& slip_velocity, const Solution& last);
  void solve_linear(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                    const Eigen::VectorXd& slip_velocity, const Solution& last);
  void find_involved();
  void add_compliance(int row, double factor, int unknown);
  void assemble();
  void assemble_cone(int pair);
  void times_cone(int pair, const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  void solve_states();
  void times_matrix(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  [[nodiscard]] bool update_states(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                   const Solution& last);
  void stick_all();
  /// Number of sweeps.
  int sweep(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free, const Eigen::VectorXd& slip_velocity,
            const Solution& last);
  double gauss_seidel_sweep(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                            const Eigen::VectorXd& slip_velocity, const Solution& last);
  double jacobi_sweep(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                      const Eigen::VectorXd& slip_velocity, const Solution& last);
  /// Number of pivots; leaves the forces alone if it finds none.
  int lemke(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free, const Solution& last);
  void states_of_forces();
  /// Of the present forces, `motion_` = D x.
  [[nodiscard]] double residual(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                const Eigen::VectorXd& slip_velocity, const Solution& last);
  /// Tangential force of a pair if its normal force and all other forces were right. `slip`: with the present forces.
  [[nodiscard]] double tangential_alone(int pair, double slip, double slip_velocity, double last) const;
  // Of solids:
  [[nodiscard]] Eigen::Vector2d along(int pair, const Eigen::VectorXd& x) const;  ///< tangential ones of all unknowns
  [[nodiscard]] Eigen::Vector2d slip_of(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const;
  [[nodiscard]] Eigen::Vector2d reach(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const;
  void find_cone_rows(const Eigen::VectorXd& slip_free, const Eigen::VectorXd& slip_velocity, const Solution& last);
  void cone_right_hand_side();
  [[nodiscard]] ConeRows stick_rows(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const;
  [[nodiscard]] ConeRows slip_rows(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const;
  [[nodiscard]] ConeRows regularised_rows(int pair, const Eigen::VectorXd& slip_free,
                                          const Eigen::VectorXd& slip_velocity) const;
  [[nodiscard]] Eigen::Vector2d cone_alone(int pair, const Eigen::VectorXd& slip_free,
                                           const Eigen::VectorXd& slip_velocity, const Solution& last) const;
  double set_along(int pair, const Eigen::Vector2d& tangential);  ///< returns the largest change
  [[nodiscard]] bool turns() const;  ///< whether the rows of a pair change while its state does not
  void finish();
  /// No tangential unknown: no friction, or supports hold both nodes (on the axis r = 0).
  [[nodiscard]] bool held(int pair) const;
  [[nodiscard]] double friction_of(int pair) const {
    return pair_laws_[static_cast<std::size_t>(pair)].friction_coefficient;
  }
  [[nodiscard]] int place(int unknown) const { return place_[static_cast<std::size_t>(unknown)]; }
  [[nodiscard]] double slack(int pair) const;     ///< 1/(alpha w) with penalty, 0 with multiplier [m/N]
  [[nodiscard]] double alone(int unknown) const;  ///< what an unknown moves its own row by [m/N]

  scene::Contact law_;
  std::vector<PairLaw> pair_laws_;
  bool regularised_;
  int pairs_;
  bool friction_;  ///< there are unknowns along the surface
  bool cone_;      ///< two tangential directions
  double dt_;
  Compliance compliance_;
  std::vector<int> involved_, place_;  ///< unknowns that `matrix_` has; of every unknown its place there, or -1
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd involved_rhs_, involved_force_;
  std::vector<PairState> states_, factored_states_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd rhs_, motion_, before_;
  Eigen::VectorXd slip_slope_, cone_slope_;  ///< of regularised friction: d tau / d slip, d tau / d lambda
  std::vector<ConeRows> cone_rows_;          ///< per pair
  std::vector<Eigen::Matrix2d> block_;       ///< per pair of solids: what its tangential forces move it by [m/N]

  Solution solution_;
};

/// Throws SolverError for a residual above 1e-3: such contact forces mean nothing.
void require_solved(const RootProblem::Solution& solution);

}  // namespace ricochet::solver
