#include "implicit_solver/contact/near_inverse.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>

namespace ricochet::implicit_solver {
namespace {

constexpr double left_out = 1e-16, most_wrong = 1e-13;  ///< of the diagonal
constexpr std::size_t measured_nodes = 8;

/// Degrees of freedom of all nodes, and the most of one.
struct Count {
  Eigen::Index dofs = 0;
  int of_a_node = 0;

  explicit Count(const std::vector<NearNode>& nodes) {
    for (const NearNode& node : nodes) {
      dofs += std::ssize(node.dofs);
      of_a_node = std::max(of_a_node, static_cast<int>(std::ssize(node.dofs)));
    }
  }
};

double distance(const NearNode& a, const NearNode& b) { return (a.position - b.position).norm(); }

/// Nodes in cells, so that those near one are found without a look at all others.
class Cells {
 public:
  Cells(const std::vector<NearNode>& nodes, double width_m) : nodes_(nodes), width_m_(width_m) {
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes_in_[cell_of(nodes[i])].push_back(i);
  }
  /// visit(i) for the nodes of the same part that are no further away than a cell is wide.
  template <class Visit>
  void near(const NearNode& node, const Visit& visit) const {
    const Cell cell = cell_of(node);
    for (int k = 0; k < 27; ++k) {
      const auto found = nodes_in_.find({cell[0], cell[1] + k % 3 - 1, cell[2] + k / 3 % 3 - 1, cell[3] + k / 9 - 1});
      if (found == nodes_in_.end()) continue;
      for (const std::size_t i : found->second)
        if (distance(node, nodes_[i]) <= width_m_) visit(i);
    }
  }

 private:
  using Cell = std::array<long, 4>;  ///< part, and along each axis
  [[nodiscard]] Cell cell_of(const NearNode& node) const {
    const auto along = [&](int axis) { return static_cast<long>(std::floor(node.position[axis] / width_m_)); };
    return {node.part, along(0), along(1), along(2)};
  }

  const std::vector<NearNode>& nodes_;
  double width_m_;
  std::map<Cell, std::vector<std::size_t>> nodes_in_;
};

/// Distance at which a push last moves another node: the largest of a few nodes, spread over all, but not less than to
/// the next node [m].
double reach_of(const std::vector<NearNode>& nodes, Eigen::Index size, const SolveFor& solve) {
  double reach = 0.0;
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(size), motion;
  for (std::size_t k = 0; k < measured_nodes; ++k) {
    const NearNode& pushed = nodes[k * (nodes.size() - 1) / (measured_nodes - 1)];
    for (const int dof : pushed.dofs) forces[dof] = 1.0;
    solve(forces, motion);
    for (const int dof : pushed.dofs) forces[dof] = 0.0;
    const double matters = left_out * std::abs(motion[pushed.dofs.front()]);
    double next = std::numeric_limits<double>::infinity();
    for (const NearNode& node : nodes) {
      if (&node == &pushed || node.part != pushed.part) continue;
      const double away = distance(node, pushed);
      next = std::min(next, away);
      if (std::any_of(node.dofs.begin(), node.dofs.end(), [&](int dof) { return std::abs(motion[dof]) > matters; }))
        reach = std::max(reach, away);
    }
    if (std::isfinite(next)) reach = std::max(reach, next);
  }
  return reach;
}

/// A number per node, which none has that is near it; nothing if that takes more than so many numbers.
std::optional<std::vector<int>> groups_of(const std::vector<NearNode>& nodes, const Cells& cells, int most) {
  std::vector<int> groups(nodes.size(), -1);
  std::vector<bool> taken;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    taken.assign(static_cast<std::size_t>(most), false);
    cells.near(nodes[i], [&](std::size_t other) {
      if (groups[other] >= 0) taken[static_cast<std::size_t>(groups[other])] = true;
    });
    groups[i] = static_cast<int>(std::find(taken.begin(), taken.end(), false) - taken.begin());
    if (groups[i] == most) return std::nullopt;
  }
  return groups;
}

}  // namespace

std::optional<NearGroups> near_groups(const std::vector<NearNode>& nodes, int most_solves, const SolveFor& solve) {
  const Count count(nodes);
  const double reach = reach_of(nodes, count.dofs, solve);
  auto groups = groups_of(nodes, Cells(nodes, 2.0 * reach), most_solves / count.of_a_node);
  if (!groups) return std::nullopt;
  return NearGroups{reach, std::move(*groups)};
}

std::optional<Eigen::SparseMatrix<double, Eigen::RowMajor>> near_inverse(const std::vector<NearNode>& nodes,
                                                                         const NearGroups& groups,
                                                                         const SolveFor& solve) {
  const Count count(nodes);
  const Eigen::Index size = count.dofs;
  const int most_dofs = count.of_a_node;
  const Cells cells(nodes, groups.reach_m);
  Eigen::VectorXd forces(size), motion, diagonal(size);
  std::vector<Eigen::Triplet<double>> entries;
  const int last = *std::max_element(groups.of_node.begin(), groups.of_node.end());
  for (int push = 0; push < (last + 1) * most_dofs; ++push) {
    const auto which = static_cast<std::size_t>(push % most_dofs);  // of a node's
    std::vector<const NearNode*> pushed;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (groups.of_node[i] == push / most_dofs && which < nodes[i].dofs.size()) pushed.push_back(&nodes[i]);
    forces.setZero();
    for (const NearNode* node : pushed) forces[node->dofs[which]] = 1.0;
    solve(forces, motion);
    for (const NearNode* node : pushed) {
      const int column = node->dofs[which];
      diagonal[column] = motion[column];
      cells.near(*node, [&](std::size_t moved) {
        for (const int row : nodes[moved].dofs)
          if (std::abs(motion[row]) > left_out * motion[column]) entries.emplace_back(row, column, motion[row]);
      });
    }
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> inverse(size, size);
  inverse.setFromTriplets(entries.begin(), entries.end());

  std::mt19937 random;
  for (double& force : forces) force = random() % 2 == 0 ? 1.0 : -1.0;
  solve(forces, motion);
  const Eigen::VectorXd wrong = (inverse * forces - motion).cwiseQuotient(diagonal);
  if (!(wrong.cwiseAbs().maxCoeff() <= most_wrong)) return std::nullopt;
  return inverse;
}

}  // namespace ricochet::implicit_solver
