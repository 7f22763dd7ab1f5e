#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <optional>
#include <vector>

namespace ricochet::implicit_solver {

/// motion = A^-1 forces, both on some degrees of freedom only.
using SolveFor = std::function<void(const Eigen::VectorXd& forces, Eigen::VectorXd& motion)>;

/// A node with such degrees of freedom. Nodes of different parts do not move each other.
struct NearNode {
  Eigen::Vector3d position;  ///< [m]
  int part = 0;
  std::vector<int> dofs;  ///< their places among the forces
};

/// Nodes that may be pushed at once.
struct NearGroups {
  double reach_m = 0.0;      ///< from which distance on a push moves nothing that counts
  std::vector<int> of_node;  ///< per node a number that none has within twice the reach
};

/// Where what is far from a force hardly moves, A^-1 has few entries that matter. With steps of the size that a wave
/// needs for an element A = M + dt^2/4 K is nearly its mass, and from node to node A^-1 falls by
/// (sqrt(c) - 1)/(sqrt(c) + 1), c the condition of A (Demko, Moss, Smith 1984), some power of ten an element.
/// An entry below 1e-16 of the diagonal counts nothing. From which distance on that is so is measured at a few
/// nodes. All nodes that are further apart than twice that are pushed at once, and what moves belongs to the nearest
/// (Curtis, Powell, Reid 1974), so that the number of solves does not grow with that of the nodes. None if it takes
/// more than `most_solves`.
[[nodiscard]] std::optional<NearGroups> near_groups(const std::vector<NearNode>& nodes, int most_solves,
                                                    const SolveFor& solve);
/// A^-1 on the degrees of freedom of `nodes`, found group by group; none if a product with it is wrong by more than
/// 1e-13 of the diagonal.
[[nodiscard]] std::optional<Eigen::SparseMatrix<double, Eigen::RowMajor>> near_inverse(
    const std::vector<NearNode>& nodes, const NearGroups& groups, const SolveFor& solve);

}  // namespace ricochet::implicit_solver
