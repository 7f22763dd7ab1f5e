#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "common/participant/heartbeat.hpp"
#include "implicit_solver/combined_parts.hpp"
#include "implicit_solver/contact/implicit_contact.hpp"
#include "implicit_solver/turned_factor.hpp"

namespace ricochet::implicit_solver {

/// Finds the increment of one window,
///   A du = b + kappa dt^2/4 G^T r,   A = M + dt/2 C + dt^2/4 (K_T + S),
/// with K_T the tangents of the parts' InternalForce where they were last linearised, C the dashpots, S the interface
/// stiffness that a protocol gives. The contact forces r come from a problem of their own (ImplicitContact), whose
/// compliance is that of this A. With linear elements A is factored once and serves for all windows.
class WindowSolver {
 public:
  /// All must outlive this object; `contact` may be null, `interface_stiffness` S in the order of the shared dofs or
  /// empty. Linearises at the parts' present displacement. `heart`: hears how far it is.
  WindowSolver(const CombinedParts& parts, ImplicitContact* contact, const Eigen::MatrixXd& interface_stiffness,
               double dt, participant::Heartbeat* heart = nullptr);
  WindowSolver(const WindowSolver&) = delete;  // the contact asks this object for products
  WindowSolver& operator=(const WindowSolver&) = delete;

  /// A at the displacement `u` (combined) from here on, and with it the contact's compliance. Everything eliminated is
  /// void.
  void linearise(const Eigen::VectorXd& u, participant::Heartbeat* heart = nullptr);
  /// The directions of the parts that A has [1]: those at the displacement where it was linearised, or those it was
  /// turned to since.
  [[nodiscard]] const std::vector<Eigen::Matrix3d>& directions() const { return factor_->directions(); }
  /// Whether A of parts that turn may be turned with them (TurnedFactor).
  [[nodiscard]] bool may_turn() const { return interface_stiffness_.size() == 0 && factor_->may_turn(); }
  /// A in other directions from here on, and the contact's compliance. Everything eliminated is void.
  void turn(const std::vector<Eigen::Matrix3d>& directions);
  /// Where A was linearised last; empty if all elements keep their tangent.
  [[nodiscard]] const Eigen::VectorXd& linearised_at() const { return linearised_at_; }
  /// The largest diagonal entry of a part's K_T.
  [[nodiscard]] double stiffest_n_m(std::size_t part) const { return stiffest_n_m_[part]; }
  /// b -= dt^2/4 K_T du of a constrained dof of a part.
  void subtract_moved(std::size_t part, int dof, double du, Eigen::VectorXd& b) const;

  /// As much of `solve` with b as does not need the link's change.
  void eliminate(const Eigen::VectorXd& b);
  /// increment = A^-1 (b - dt^2/4 (link - link_before) + contact forces), counted from `from` if that is given, which
  /// is 0 at constrained dofs; these stay. `eliminate` with the same b comes before.
  void solve(const Eigen::VectorXd& b, const Eigen::VectorXd& link_before, const Eigen::VectorXd& link,
             const Eigen::VectorXd* from, Eigen::VectorXd& increment);
  /// increment += A^-1 (b + contact forces), where b is what the increment without contact forces leaves undone.
  void improve(const Eigen::VectorXd& b, Eigen::VectorXd& increment);

 private:
  [[nodiscard]] fem::SparseMatrix assemble(const Eigen::VectorXd& u, std::vector<bool>& active);
  void add_interface_stiffness(double scale, fem::SparseMatrix& a) const;
  void choose_root(const fem::SparseMatrix& a, const std::vector<bool>& active);
  [[nodiscard]] bool contact_belongs_in_root(const fem::SparseMatrix& a, const std::vector<bool>& active);
  void prepare_contact();
  void begin_from(const Eigen::VectorXd& from);
  void find_increment(const Eigen::VectorXd* from, bool again, Eigen::VectorXd& increment);
  void solve_contact_outside_root(const Eigen::VectorXd* from, bool again, Eigen::VectorXd& increment);
  template <class Factor>
  void move_by(const Eigen::VectorXd& forces, Factor& factor);

  const CombinedParts& parts_;
  ImplicitContact* contact_;
  const Eigen::MatrixXd& interface_stiffness_;
  double dt_;
  std::vector<const fem::SparseMatrix*> tangents_;  ///< per part
  std::vector<double> stiffest_n_m_;                ///< per part
  Eigen::VectorXd linearised_at_;
  std::optional<TurnedFactor> factor_;
  std::vector<int> root_;
  std::vector<std::pair<int, Eigen::Index>> shared_roots_;  ///< shared dof, its place in the root
  bool link_in_root_ = true;
  std::optional<bool> contact_in_root_;  ///< once chosen
  Eigen::VectorXd b_with_link_, root_rhs_, root_increment_, root_force_, from_;
  Eigen::VectorXd contact_force_, contact_increment_;  ///< of a contact outside the root, all dofs
};

}  // namespace ricochet::implicit_solver
