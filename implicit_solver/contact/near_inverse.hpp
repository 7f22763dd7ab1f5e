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

/// A^-1 on the degrees of freedom of `nodes`, if what is far from a force hardly moves: then it has few entries that
/// matter. With steps of the size that a wave needs for an element A = M + dt^2/4 K is nearly its mass, and from node
/// to node A^-1 falls by (sqrt(c) - 1)/(sqrt(c) + 1), c the condition of A (Demko, Moss, Smith 1984), some power of ten
/// an element.
/// Left out is what is less than 1e-16 of the diagonal. From which distance on that is so is measured at a few nodes.
/// Then all nodes that are further apart than twice that are pushed at once, and what moves belongs to the nearest
/// (Curtis, Powell, Reid 1974), so that the number of solves does not grow with that of the nodes. There is no such
/// matrix if it takes more than `most_solves`, or if a product with it is wrong by more than 1e-13 of the diagonal.
[[nodiscard]] std::optional<Eigen::SparseMatrix<double, Eigen::RowMajor>> near_inverse(
    const std::vector<NearNode>& nodes, int most_solves, const SolveFor& solve);

}  // namespace ricochet::implicit_solver
