#pragma once

#include <Eigen/Core>
#include <set>
#include <vector>

#include "common/fem/mesh.hpp"
#include "common/fem/part.hpp"

/// Hanging nodes are eliminated: with T that gives all nodes the motion of those that do not hang, u = T u', the forces
/// on these are T^T f, their stiffness T^T K T, and their lumped mass that of T^T M T summed by rows. Where weights are
/// >= 0, the latter has for any motion u' at least the kinetic energy of T u', so the largest frequency is no higher
/// than that of the elements alone. In a tie weights < 0 could leave a part a negative mass, so masses go to the nodes
/// around a hanging one. Sums of forces, masses and first moments stay what they were.
namespace ricochet::fem {

/// Null if the node does not hang.
[[nodiscard]] const HangingNode* hanging_at(const Mesh& mesh, int node);

/// visit(node) of the nodes that say how an element moves: its own, in place of those that hang their carriers. One may
/// come more than once.
template <class Visit>
void for_each_carrier(const Mesh& mesh, const Element& element, const Visit& visit) {
  for (const int node : element) {
    if (const HangingNode* hanging = hanging_at(mesh, node)) {
      for (const auto& carrier : hanging->carriers) visit(carrier.node);
      for (const auto& carrier : hanging->between) visit(carrier.node);
      for (const auto& carrier : hanging->beside) visit(carrier.node);
    } else {
      visit(node);
    }
  }
}

/// The same sum with the shares of hanging nodes given to their carriers, ascending by node, each once.
[[nodiscard]] std::vector<WeightedNode> carried(const Mesh& mesh, const std::vector<WeightedNode>& nodes);

/// Nodes in ascending order, in place of those that hang their carriers.
[[nodiscard]] std::vector<int> carriers_of(const Mesh& mesh, const std::vector<int>& nodes);

/// Gives the forces on hanging nodes to their carriers.
void pass_on(const std::vector<HangingNode>& hanging, int components, Eigen::VectorXd& forces);
/// Gives masses, one a node, to HangingNode::mass_bearers.
void pass_on_masses(const std::vector<HangingNode>& hanging, Eigen::VectorXd& masses);

/// Hanging nodes take the displacement, velocity or acceleration of their carriers.
void follow(const std::vector<HangingNode>& hanging, int components, Eigen::VectorXd& values);

/// K becomes T^T K T; rows and columns of hanging nodes are left without entries.
void eliminate(const std::vector<HangingNode>& hanging, int components, SparseMatrix& stiffness);

/// The faces between large elements and the small ones on them: each belongs to one element alone, and yet none is of
/// the body's boundary. A tie has those whose nodes hang on one face alone; the others are seen where pieces meet.
class FacesBetweenSizes {
 public:
  explicit FacesBetweenSizes(const Mesh& mesh);
  [[nodiscard]] bool has(const Face& face) const;

 private:
  const Mesh& mesh_;
  std::set<std::vector<int>> large_;  ///< of the large elements, ascending: a node hangs in the middle of each
};

}  // namespace ricochet::fem
