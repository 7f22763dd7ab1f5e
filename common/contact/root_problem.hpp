#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/archive.hpp"
#include "common/contact/compliance.hpp"
#include "common/contact/contact_record.hpp"
#include "common/contact/pair_system.hpp"
#include "common/contact/projected_sweep.hpp"
#include "common/contact/projection.hpp"
#include "common/scene/scene.hpp"

namespace ricochet::solver {

/// The contact problem of one window. Unknowns: normal force lambda_i >= 0 on B along +n and, with
/// friction, tangential force tau_i on B along +t [N], of solids along the binormal, too. Ordering: all normals, then
/// all along t, then all along the binormal.
///   gap_i  = gap_free_i  + (D x)_i          [m]   gap at n + 1
///   slip_i = slip_free_i + (D x)_{n+i}      [m]   slip increment of the window; of solids two components
/// multiplier: lambda >= 0, gap >= 0, lambda gap = 0.         penalty: lambda = alpha w max(0, -gap) (Eq. 8-10)
/// return mapping: |tau| <= mu lambda; stick: slip = 0 (penalty: tau = tau_n - alpha w slip); slip: |tau| = mu lambda,
/// tau = -eta slip, eta >= 0 (Eq. 21-24).            regularised: tau = -mu lambda tanh(xi |v_t|) v_t/|v_t| (Eq. 14,
/// 15), with v_t = 2 slip / dt - v_t,n the relative tangential velocity at n + 1.
/// Along a tangent and a binormal the cone is circular; a tangent alone is its case of one dimension.
///
/// These are equations between x and projections of it (Projection), solved by a semismooth Newton method (Alart,
/// Curnier 1991), which starts from the forces and states of the last window. Where it does not settle, projected
/// Gauss-Seidel goes on, and Newton from there. The rest that is not solved stands in Solution::residual.
class RootProblem {
 public:
  /// The numbers that are a pair's own: w and mu.
  struct PairLaw {
    double area_m2 = 0.0;
    double friction_coefficient = 0.0;
  };
  /// `compliance` D, n x n without friction, 2n x 2n with, of solids 3n x 3n; then it has the rows of pairs without
  /// friction, too, which have no forces there. `law`: all but its mu.
  RootProblem(const scene::Contact& law, Compliance compliance, const std::vector<PairLaw>& pairs, double dt);

  struct Solution {
    Eigen::VectorXd force;             ///< x of the class comment
    std::vector<ContactState> states;  ///< per pair
    int iterations = 0;                ///< linear solves and sweeps
    /// Largest violation of the conditions above, each as the change of force that would mend it alone, relative to the
    /// largest normal force; where sweeps have settled, or find a part of the forces, their largest last change.
    double residual = 0.0;

    void archive(Archive& a) { a(force, states, iterations, residual); }
  };

  /// `slip_free` and `slip_velocity` (v_t,n [m/s]), of solids all along t first, are ignored without friction. `last`
  /// is the accepted solution of the window before (tangential forces of the penalty law; forces and states to start
  /// from, where `from` gives no nearer ones).
  const Solution& solve(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                        const Eigen::VectorXd& slip_velocity, const Solution& last, const Solution* from = nullptr);
  /// By sweeps from no forces and a multiplier, for a D that couples few pairs: of one that couples none the first is
  /// right. Newton's method goes on where they do not settle, as where nodes hang. `normal`: forces along n where they
  /// are known, else empty; `held`: `hold` of the others.
  const Solution& sweep_from_none(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free,
                                  const Eigen::VectorXd& normal, bool held);

  /// Every pair closed and, with friction, sticking, whatever the sign of its force: the linear problem gap = 0, slip =
  /// 0 (penalty: of springs). Here `slip_free` counts from zero, not from the window before.
  const Solution& hold(const Eigen::VectorXd& gap_free, const Eigen::VectorXd& slip_free);
  /// The state of `hold` with the penalty springs' forces at this gap and slip; multiplier: no forces.
  const Solution& spring(const Eigen::VectorXd& gap, const Eigen::VectorXd& slip);

  [[nodiscard]] Solution open() const;  ///< all pairs open, no force
  [[nodiscard]] const Compliance& compliance() const { return compliance_; }

 private:
  struct Window {
    const Eigen::VectorXd &gap_free, &slip_free, &slip_velocity, &last;  ///< forces of the window before
  };
  [[nodiscard]] int pairs() const { return static_cast<int>(blocks_.size()); }
  [[nodiscard]] Eigen::Index unknown(int pair, int direction) const { return Eigen::Index{direction} * pairs() + pair; }
  /// A pair's numbers along normal, tangent and binormal.
  [[nodiscard]] Eigen::Vector3d of_pair(int pair, const Eigen::VectorXd& x) const;
  [[nodiscard]] PairWindow window_of(int pair, const Window& window) const;
  /// Leaves D x of the forces in `motion_`.
  /// `soft`: what closed pairs give way by besides, of what they yield.
  void newton(const Window& window, double soft = 0.0);
  [[nodiscard]] bool find_rows(const Window& window, double soft);
  [[nodiscard]] int update_states(const Window& window, bool all);
  void start_nearer(const Window& window, const Solution& start);
  void fall_back(const Window& window);
  void go_on_by_newton(const Window& window, double soft);
  void gauss_seidel(const Window& window, int most);
  [[nodiscard]] bool rubs() const;  ///< whether any pair has friction
  void states_of_forces();
  [[nodiscard]] double violation(const Window& window) const;
  [[nodiscard]] double residual(const Window& window) const;
  void finish();

  Projection projection_;
  int directions_;
  Compliance compliance_;
  std::vector<PairBlock> blocks_;
  std::vector<PairRows> rows_;
  PairSystem system_;
  Eigen::VectorXd motion_, before_;
  Solution solution_;
};

/// Throws SolverError for a residual above 1e-3: such contact forces mean nothing.
void require_solved(const RootProblem::Solution& solution);

}  // namespace ricochet::solver
