#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/base/window_clock.hpp"
#include "common/participant/heartbeat.hpp"
#include "implicit_solver/combined_parts.hpp"
#include "implicit_solver/contact/implicit_contact.hpp"
#include "implicit_solver/window_solver.hpp"

namespace ricochet::implicit_solver {

/// One window of the trapezoidal rule (Newmark, beta = 1/4, gamma = 1/2) on the implicit elements, the shared nodes
/// (with the summed mass, Eq. 28) and the contact nodes, in increments (Eq. 16). With q_n the elastic residual and L of
/// WindowState, one window is
///   (M + dt^2/4 K) du = M (dt v_n + dt^2/4 a_n) + dt^2/4 (q_n + df - dL) + kappa dt^2/4 G^T r,   dL = Delta P
///   a*_{n+1} = 4/dt^2 (du - dt v_n) - a_n,   v_{n+1} = v_n + dt/2 (a_n + a*_{n+1}),   q_{n+1} = M a*_{n+1} - kappa G^T
///   r
/// Dashpots C of absorbing surfaces put -C (v - v_0) into f at n and n + 1: M + dt/2 C + dt^2/4 K on the left, and
/// dt^2/2 C v_n on the right.
/// Where a protocol gives an interface stiffness S, L = given + S u and S joins K in the operator.
/// That equation is solved by WindowSolver. Elements that keep their tangent, but are not linear, keep its factor and
/// the contact's answer for the whole run. They return to the yield stress at a place near the window's end and hold
/// that plastic strain: the window is linear, and its balances are to rounding, whatever they hold (operator splitting
/// after Nakashima 1990). The first place goes on as the last window did; one found by rates would ring in elements far
/// finer than the window. The next ones come from where the window ended, by Broyden's method.
/// Elements of any other kind are solved by Newton's method,
///   M a*_{n+1} + P(u_n + du) = f_{n+1} - L_{n+1} + kappa G^T r,
/// until no more is out of balance than 1e-10 of the largest force or what the contact's forces are not known to, or
/// with a SolverError. It begins where parts that turn would be if they moved on as rigid bodies, with an operator that
/// turns with them.
class NewmarkWindow {
 public:
  /// `contact` (null: none) and `parts` must outlive this object; `interface_stiffness` S in the order of the shared
  /// dofs, or empty. `heart`: hears how far it is.
  NewmarkWindow(const CombinedParts& parts, ImplicitContact* contact, Eigen::MatrixXd interface_stiffness,
                const WindowClock& clock, participant::Heartbeat* heart = nullptr);

  /// The right-hand side without the link's change, and as much of the solve as does not need that. Does nothing if it
  /// is done already.
  void prepare(std::int64_t window, const WindowState& state, WindowTrial& trial);
  /// The window; `trial.end.link` holds the link's given force.
  void advance(std::int64_t window, const WindowState& state, WindowTrial& trial);
  /// The state is another: what was prepared is void.
  void forget();
  /// Windows begin with another operator from here on, linearised at a displacement and turned to these directions; of
  /// linear elements it is the same.
  void begin_with(const Eigen::VectorXd& linearised_at, const std::vector<Eigen::Matrix3d>& directions);
  [[nodiscard]] const Eigen::VectorXd& linearised_at() const { return accepted_.linearised_at; }
  /// The increment of the accepted window, where elements hold what the next one starts with; else empty.
  [[nodiscard]] const Eigen::VectorXd& last_increment() const { return held_.last_increment; }
  void set_last_increment(const Eigen::VectorXd& increment) { held_.last_increment = increment; }
  /// The directions that windows' operators have, of parts that turn (WindowSolver::directions).
  [[nodiscard]] const std::vector<Eigen::Matrix3d>& directions() const { return accepted_.directions; }
  /// Accounts work and impulses of the contact in the trial that becomes final.
  void account(const WindowTrial& trial);
  /// link += S u of the accepted motion.
  void add_interface_force(Eigen::VectorXd& link);
  [[nodiscard]] bool has_interface_stiffness() const { return interface_stiffness_.size() > 0; }

 private:
  /// A root dof of the contact: combined number, part, local number.
  struct Root {
    int dof;
    std::size_t part;
    int local;
  };
  /// The displacement where the operator was linearised, and the directions it was turned to.
  struct Operator {
    Eigen::VectorXd linearised_at;
    std::vector<Eigen::Matrix3d> directions;
  };
  /// Elements that hold what they change in a window need this.
  struct Held {
    Eigen::VectorXd last_increment;
    Eigen::VectorXd place;         ///< increment that elements hold the change at
    Eigen::VectorXd change, next;  ///< of force by what elements hold [N]: that in rhs_, and the next
    /// Window that was tried last, and the largest number of places that one of its trials took: later ones take as
    /// many, so that a protocol that repeats windows finds a continuous answer.
    std::int64_t window = -1;
    int places = 0;
  };
  /// Newton's iteration needs what is out of balance and its parts [N], and increments [m]: the one that it begins with
  /// and the one before a step.
  struct Newton {
    Eigen::VectorXd imbalance, link, internal, inertia, no_link;
    Eigen::VectorXd predicted, before;
  };
  template <class Displacement>
  void add_stiffness_force(const Displacement& displacement, Eigen::VectorXd& link);
  /// link += S increment.
  void add_interface_force_of(const Eigen::VectorXd& increment, Eigen::VectorXd& link);
  void damp_rhs();
  void constrain_increment(double time_s, WindowTrial& trial);
  void predict(const WindowTrial& trial);
  void hold();
  void settle(std::int64_t window, const WindowState& last, WindowTrial& trial);
  void begin_balance(WindowTrial& trial);
  void turn_ahead(const std::vector<fem::RigidMotion>& begin, const std::vector<fem::RigidMotion>& end);
  [[nodiscard]] bool turn_to(const Eigen::VectorXd& u);
  void balance(std::int64_t window, WindowTrial& trial);
  [[nodiscard]] bool is_balanced(const Eigen::VectorXd& left, double largest_n, const WindowTrial& trial,
                                 double& moved_m) const;
  double find_imbalance(const WindowTrial& trial);
  double find_imbalance(const Eigen::VectorXd& increment, const Eigen::VectorXd& external, const Eigen::VectorXd& link);
  void mend(Eigen::VectorXd& step);
  void remember(Eigen::VectorXd step);
  bool shorten(const Eigen::VectorXd& step, WindowTrial& trial, double& largest_n);
  [[nodiscard]] Eigen::VectorXd imbalance_with_contact() const;
  [[noreturn]] void refuse_unbalanced(std::int64_t window, int improvements, const Eigen::VectorXd& left) const;
  void find_rates(WindowTrial& trial);
  void find_contact_rates(WindowTrial& trial);
  void set_dashpot_forces(WindowTrial& trial) const;

  const CombinedParts& parts_;
  ImplicitContact* contact_;
  const WindowClock& clock_;
  double dt_;  ///< that the factor is of [s]
  Eigen::MatrixXd interface_stiffness_;
  bool holds_;  ///< there are elements that keep their tangent and are not linear
  WindowSolver solver_;
  Operator accepted_, tried_;  ///< each trial of a window starts from the one of the accepted window
  std::vector<Root> roots_;
  std::int64_t prepared_ = -1;  ///< window that `prepare` was done for
  Eigen::VectorXd rhs_, shared_x_, shared_force_;
  Held held_;
  Newton newton_;
  std::vector<Eigen::VectorXd> steps_;             ///< of either, in this window, by the present operator
  std::vector<std::vector<double>> dashpot_load_;  ///< per part and dashpot: other external force at n + 1 [N]
  Eigen::VectorXd mean_velocity_;                  ///< see ImplicitContact::account
};

}  // namespace ricochet::implicit_solver
