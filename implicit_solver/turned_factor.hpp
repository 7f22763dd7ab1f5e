#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "implicit_solver/combined_parts.hpp"
#include "implicit_solver/condensed_factor.hpp"

namespace ricochet::implicit_solver {

/// The factor of A of parts that turn: where a part has turned by T since A was factored, A is T A T^T, since its
/// masses are alike in all directions. Vectors are turned to and fro, and the factor stays. A part that a plane of
/// symmetry holds along one axis turns about that alone. All vectors here have the directions of space; the root is
/// that of CondensedFactor.
class TurnedFactor {
 public:
  /// `a`: A of parts with these directions (CombinedParts::rotations). `parts` must outlive this object; see
  /// CondensedFactor for `active` and `root`.
  TurnedFactor(const CombinedParts& parts, std::vector<Eigen::Matrix3d> directions, fem::SparseMatrix a,
               const std::vector<bool>& active, const std::vector<int>& root, participant::Heartbeat* heart);

  /// Whether A of every part with a frame turns with it: of each of its nodes all components have one mass, and all
  /// are active or none, or all but the one of its axis; those are in the root together.
  [[nodiscard]] bool may_turn() const { return may_turn_; }
  /// A of each part has these directions from here on.
  void turn(const std::vector<Eigen::Matrix3d>& directions);
  [[nodiscard]] const std::vector<Eigen::Matrix3d>& directions() const { return directions_; }
  /// T of each part; of one with an axis what of it is a turn about that. Empty: none has turned.
  [[nodiscard]] const std::vector<Eigen::Matrix3d>& turned_by() const { return by_; }

  /// As of CondensedFactor.
  void forward(const Eigen::VectorXd& b);
  [[nodiscard]] const Eigen::VectorXd& root_rhs() const { return turned() ? root_rhs_ : factor_.root_rhs(); }
  /// x = S^-1 rhs.
  void solve_root(const Eigen::VectorXd& rhs, Eigen::VectorXd& x);
  /// x += S^-1 of forces on the first unknowns of the root.
  void add_root_motion(const Eigen::VectorXd& forces, Eigen::VectorXd& x);
  /// As of CondensedFactor.
  void backward(const Eigen::VectorXd& x_root, Eigen::VectorXd& x);
  /// Degrees of freedom that are not active.
  [[nodiscard]] const std::vector<int>& inactive() const { return inactive_; }
  /// In the directions in which A was factored.
  [[nodiscard]] CondensedFactor& as_factored() { return factor_; }
  [[nodiscard]] const Eigen::MatrixXd& root_inverse() const { return factor_.root_inverse(); }

 private:
  /// The places of a node's components in the root; -1: not an unknown.
  struct RootNode {
    std::size_t part;
    std::array<int, 3> places;
  };
  [[nodiscard]] bool turned() const { return !by_.empty(); }
  [[nodiscard]] bool find_axis(std::size_t part, const std::vector<bool>& active);
  [[nodiscard]] bool collect_root(const std::vector<int>& root, const std::vector<bool>& active);
  void turn_all(bool back, Eigen::VectorXd& x) const;
  void turn_root(bool back, Eigen::VectorXd& x) const;

  const CombinedParts& parts_;
  std::vector<Eigen::Matrix3d> factored_, directions_;  ///< per part: of A as it was factored, and of A
  CondensedFactor factor_;
  int components_ = 1;
  bool may_turn_ = true;
  std::vector<int> axis_;  ///< per part: the component that is held in some of its nodes; -1: it turns any way
  std::vector<int> inactive_;
  std::vector<RootNode> root_nodes_;  ///< of parts with a frame
  std::vector<Eigen::Matrix3d> by_;   ///< see turned_by
  Eigen::VectorXd all_, root_rhs_, root_forces_, root_motion_;
};

}  // namespace ricochet::implicit_solver
