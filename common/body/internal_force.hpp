#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/fem/part.hpp"

namespace ricochet::solver {

/// Rows first ... last - 1 of a part.
struct Rows {
  int first = 0, last = 0;
};

/// The answer of one part's elements to a displacement u [m] of its degrees of freedom: the force P(u) [N] in M a =
/// f - P(u), and the energy they store. An integrator knows no more of a part than this; of linear elements P = K u
/// (LinearElements, and explicit_solver::LinearForce).
///
/// Where a link says how shared nodes move, a window goes in two halves: `before_link` computes what needs no shared
/// node, `after_link` the rest. The second may be repeated with another motion of the shared nodes.
class InternalForce {
 public:
  virtual ~InternalForce() = default;

  /// force = P(u) in `rows`, `step_s` after the step before: of the same instant 0. Other rows are left alone. In a
  /// share of a part u of other ranks' nodes is written.
  virtual void evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) = 0;
  /// The halves of `evaluate`: u with the shared nodes where they were, then where they are.
  virtual void before_link(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force);
  virtual void after_link(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force);
  /// P of a step, which was evaluated last; the next step begins there. `rows` may grow.
  virtual void follow(const Eigen::VectorXd& force);
  /// Whether what it follows may change what it answers.
  [[nodiscard]] virtual bool remembers() const;
  /// The steps followed so far are those of an accepted window: none of them will be repeated.
  virtual void settle();
  /// Undoes the steps followed since then, which are to be tried again.
  virtual void go_back();

  /// Elements with a memory change it as at `u`, and hold it there until `follow` or `let_go`: P is linear meanwhile,
  /// and smaller by `change` [N] than with the memory of the step before.
  virtual void hold(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& change);
  virtual void let_go();
  /// Whether that is near enough what it would be at u, of a step that ends there.
  [[nodiscard]] virtual bool hold_enough(Eigen::VectorXd& u);
  /// force = P(u) with the memory of the last step, whatever it would change to.
  virtual void evaluate_at_rest(Eigen::VectorXd& u, Eigen::VectorXd& force);

  /// The rows to compute, ascending, none touching the next; in all others there is neither force nor acceleration.
  [[nodiscard]] virtual const std::vector<Rows>& rows() const = 0;
  /// From here on all rows are computed: the motion is no longer what the part began with.
  virtual void reach_all();

  /// Forces held over a window amount to this at its end [N], in place: M a = S f - P(u). Where elements step locally
  /// f acts inside the small steps, and S is not 1 (fem::LocalSteps).
  virtual void spread(Eigen::VectorXd& force);
  [[nodiscard]] virtual bool spreads(int dof) const;
  /// R where that is R S R^T: of the frame of a part that turns, at its last evaluation. Else null.
  [[nodiscard]] virtual const Eigen::Matrix3d* turn() const;
  /// Energy left out by S [J]: of that of the elements at u, with S P(u) in `force`, and of the work of the forces
  /// inside the small steps so far.
  struct Unspread {
    double half_work_j = 0.0, work_j = 0.0;
  };
  [[nodiscard]] virtual Unspread unspread(const Eigen::VectorXd& u, const Eigen::VectorXd& force);

  /// Whether P(u + d) = P(u) + K d. Then a trial may be corrected by what the change of a force moves, alone.
  [[nodiscard]] virtual bool linear() const = 0;
  /// Energy of the elements at u, where P(u) is `force` [J]; `half_work_j` = u . P(u)/2, which is it where P is linear.
  [[nodiscard]] virtual double stored(const Eigen::VectorXd& u, const Eigen::VectorXd& force,
                                      double half_work_j) const = 0;

  /// The matrix of an implicit window [N/m], symmetric: K_T = dP/du at u, which stays as it is until the next
  /// call; or, if it `keeps_tangent`, one matrix for all u that is nowhere smaller than K_T. Such elements,
  /// where they are not linear, `hold`.
  [[nodiscard]] virtual const fem::SparseMatrix& tangent(const Eigen::VectorXd& u) = 0;
  [[nodiscard]] virtual bool keeps_tangent() const;

  /// All that the next window depends on beside u.
  virtual void archive(Archive& a);
};

/// The state that it keeps, as bytes, and that put back. Throws ConfigError where the bytes are another part's.
[[nodiscard]] inline std::string kept_by(InternalForce& force) {
  Archive out;
  force.archive(out);
  return out.take();
}
inline void put_back(const std::string& kept, InternalForce& force) {
  Archive in(kept, "what the elements of a part keep");
  force.archive(in);
  in.end();
}

inline void InternalForce::before_link(double, Eigen::VectorXd&, Eigen::VectorXd&) {}
inline void InternalForce::after_link(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  evaluate(step_s, u, force);
}
inline void InternalForce::follow(const Eigen::VectorXd&) {}
inline bool InternalForce::remembers() const { return !linear(); }
inline void InternalForce::settle() {}
inline void InternalForce::go_back() {}
inline void InternalForce::hold(double, Eigen::VectorXd&, Eigen::VectorXd& change) { change.setZero(); }
inline void InternalForce::let_go() {}
inline bool InternalForce::hold_enough(Eigen::VectorXd&) { return true; }
inline void InternalForce::evaluate_at_rest(Eigen::VectorXd& u, Eigen::VectorXd& force) { evaluate(0.0, u, force); }
inline void InternalForce::reach_all() {}
inline void InternalForce::spread(Eigen::VectorXd&) {}
inline bool InternalForce::spreads(int) const { return false; }
inline const Eigen::Matrix3d* InternalForce::turn() const { return nullptr; }
inline InternalForce::Unspread InternalForce::unspread(const Eigen::VectorXd&, const Eigen::VectorXd&) { return {}; }
inline bool InternalForce::keeps_tangent() const { return linear(); }
inline void InternalForce::archive(Archive&) {}

}  // namespace ricochet::solver
