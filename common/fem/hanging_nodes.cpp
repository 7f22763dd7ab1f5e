#include "common/fem/hanging_nodes.hpp"

#include <algorithm>
#include <utility>

namespace ricochet::fem {
namespace {

std::vector<WeightedNode> sorted_by_node(std::vector<WeightedNode> nodes) {
  std::stable_sort(nodes.begin(), nodes.end(),
                   [](const WeightedNode& x, const WeightedNode& y) { return x.node < y.node; });
  return nodes;
}

}  // namespace

const HangingNode* hanging_at(const Mesh& mesh, int node) {
  const auto found = std::lower_bound(mesh.hanging.begin(), mesh.hanging.end(), node,
                                      [](const HangingNode& hanging, int n) { return hanging.node < n; });
  return found != mesh.hanging.end() && found->node == node ? &*found : nullptr;
}

std::vector<WeightedNode> carried(const Mesh& mesh, const std::vector<WeightedNode>& nodes) {
  std::vector<WeightedNode> all;
  for (const WeightedNode& of : nodes) {
    if (const HangingNode* hanging = hanging_at(mesh, of.node)) {
      for (const auto& carrier : hanging->carriers) all.push_back({carrier.node, of.weight * carrier.weight});
    } else {
      all.push_back(of);
    }
  }
  std::vector<WeightedNode> sums;
  for (const WeightedNode& of : sorted_by_node(std::move(all))) {
    if (sums.empty() || sums.back().node != of.node) {
      sums.push_back(of);
    } else {
      sums.back().weight += of.weight;
    }
  }
  return sums;
}

std::vector<int> carriers_of(const Mesh& mesh, const std::vector<int>& nodes) {
  std::vector<WeightedNode> weighted;
  for (const int node : nodes) weighted.push_back({node, 1.0});
  std::vector<int> carriers;
  for (const WeightedNode& of : carried(mesh, weighted)) carriers.push_back(of.node);
  return carriers;
}

void pass_on(const std::vector<HangingNode>& hanging, int components, Eigen::VectorXd& forces) {
  for (const HangingNode& of : hanging) {
    for (int c = 0; c < components; ++c) {
      if (!of.hangs(c)) continue;
      double& own = forces[of.node * components + c];
      for (const auto& carrier : of.carriers) forces[carrier.node * components + c] += carrier.weight * own;
      own = 0.0;
    }
  }
}

void pass_on_masses(const std::vector<HangingNode>& hanging, Eigen::VectorXd& masses) {
  for (const HangingNode& of : hanging) {
    for (const auto& carrier : of.mass_bearers()) masses[carrier.node] += carrier.weight * masses[of.node];
    masses[of.node] = 0.0;
  }
}

void follow(const std::vector<HangingNode>& hanging, int components, Eigen::VectorXd& values) {
  for (const HangingNode& of : hanging) {
    for (int c = 0; c < components; ++c) {
      if (!of.hangs(c)) continue;
      double sum = 0.0;
      for (const auto& carrier : of.carriers) sum += carrier.weight * values[carrier.node * components + c];
      values[of.node * components + c] = sum;
    }
  }
}

void eliminate(const std::vector<HangingNode>& hanging, int components, SparseMatrix& stiffness) {
  if (hanging.empty()) return;
  const Eigen::Index dofs = stiffness.rows();
  std::vector<const HangingNode*> hangs(static_cast<std::size_t>(dofs), nullptr);
  for (const HangingNode& of : hanging)
    for (int c = 0; c < components; ++c)
      if (of.hangs(c)) hangs[at(of.node * components + c)] = &of;
  const auto touched = [&](Eigen::Index row, Eigen::Index column) {
    return hangs[static_cast<std::size_t>(row)] != nullptr || hangs[static_cast<std::size_t>(column)] != nullptr;
  };
  // Triplets of the products would take ten times the memory of the rest where a large surface is tied.
  SparseMatrix follows(dofs, dofs), moved(dofs, dofs);  // T; the entries of hanging nodes
  for (Eigen::Index row = 0; row < dofs; ++row) {
    follows.startVec(row);
    moved.startVec(row);
    if (const HangingNode* of = hangs[static_cast<std::size_t>(row)]) {
      for (const WeightedNode& carrier : sorted_by_node(of->carriers))
        follows.insertBack(row, carrier.node * components + row % components) = carrier.weight;
    } else {
      follows.insertBack(row, row) = 1.0;
    }
    for (SparseMatrix::InnerIterator entry(stiffness, row); entry; ++entry)
      if (touched(row, entry.col())) moved.insertBack(row, entry.col()) = entry.value();
  }
  follows.finalize();
  moved.finalize();
  const SparseMatrix carried_rows = follows.transpose();
  moved = SparseMatrix(moved * follows);
  SparseMatrix added = carried_rows * moved;
  // Sums of an entry and of its mirror image run in different orders.
  const SparseMatrix mirrored = added.transpose();
  added = 0.5 * (added + mirrored);
  SparseMatrix sum(dofs, dofs);
  sum.reserve(stiffness.nonZeros() + added.nonZeros());
  for (Eigen::Index row = 0; row < dofs; ++row) {
    sum.startVec(row);
    SparseMatrix::InnerIterator more(added, row);
    for (SparseMatrix::InnerIterator entry(stiffness, row); entry; ++entry) {
      if (touched(row, entry.col())) continue;
      for (; more && more.col() < entry.col(); ++more) sum.insertBack(row, more.col()) = more.value();
      const bool both = more && more.col() == entry.col();
      sum.insertBack(row, entry.col()) = both ? entry.value() + more.value() : entry.value();
      if (both) ++more;
    }
    for (; more; ++more) sum.insertBack(row, more.col()) = more.value();
  }
  sum.finalize();
  stiffness.swap(sum);
}

FacesBetweenSizes::FacesBetweenSizes(const Mesh& mesh) : mesh_(mesh) {
  if (mesh.rigid_nodes > 0) return;
  const std::size_t nodes_of_face = mesh.model == Model::solid ? 4 : 2;
  for (const HangingNode& of : mesh.hanging)
    if (of.carriers.size() == nodes_of_face) large_.insert(carriers_of(mesh, {of.node}));
}

/// The face of a small element has a node in the middle of the large one's, or of its edge in two dimensions.
bool FacesBetweenSizes::has(const Face& face) const {
  if (large_.empty()) return false;
  const Face in_order = sorted(face);
  if (large_.contains({in_order.begin(), in_order.end()})) return true;
  return std::any_of(face.begin(), face.end(), [&](int middle) {
    if (hanging_at(mesh_, middle) == nullptr) return false;
    const std::vector<int> large = carriers_of(mesh_, {middle});
    const auto on_it = [&](int node) {
      const std::vector<int> of = carriers_of(mesh_, {node});
      return std::includes(large.begin(), large.end(), of.begin(), of.end());
    };
    return large_.contains(large) && std::all_of(face.begin(), face.end(), on_it);
  });
}

}  // namespace ricochet::fem
