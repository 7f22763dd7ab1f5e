// Rows of nodes that hang go to the nodes that carry these.
#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "common/fem/hanging_nodes.hpp"
#include "common/problem/contact_pairs.hpp"

namespace ricochet::scene {
namespace {

/// Sums over the rows that make up one, each weighed by its area.
struct RowSum {
  double area_m2 = 0.0, gap_m3 = 0.0;
  Eigen::Vector3d normal_m2 = Eigen::Vector3d::Zero();
  std::vector<WeightedNode> a, b;

  void add(double area, const ContactPair& pair) {
    area_m2 += area;
    gap_m3 += area * pair.gap0_m;
    normal_m2 += area * pair.normal;
    for (const auto& [node, weight] : own_nodes(pair)) a.push_back({node, area * weight});
    for (const auto& [node, weight] : pair.b) b.push_back({node, area * weight});
  }
  void take(const fem::Mesh& mesh_a, const fem::Mesh* mesh_b, ContactPair& pair) const {
    const auto mean = [this](std::vector<WeightedNode> sum) {
      for (auto& of : sum) of.weight /= area_m2;
      return sum;
    };
    pair.area_m2 = area_m2;
    pair.gap0_m = gap_m3 / area_m2;
    pair.normal = normal_m2.normalized();
    pair.a = mean(fem::carried(mesh_a, a));
    if (mesh_b != nullptr) pair.b = mean(fem::carried(*mesh_b, b));
  }
};

}  // namespace

void carry(const fem::Mesh& mesh_a, const fem::Mesh* mesh_b, std::vector<ContactPair>& pairs) {
  if (mesh_b != nullptr && !mesh_b->hanging.empty())
    for (ContactPair& pair : pairs) pair.b = fem::carried(*mesh_b, pair.b);
  if (mesh_a.hanging.empty()) return;
  for (ContactPair& pair : pairs) {
    if (pair.a.empty()) continue;
    pair.a = fem::carried(mesh_a, pair.a);
    pair.node_a = std::ranges::max_element(pair.a, {}, &WeightedNode::weight)->node;
  }
  const auto hangs = [&](const ContactPair& pair) { return fem::hanging_at(mesh_a, pair.node_a) != nullptr; };
  const auto first = std::stable_partition(pairs.begin(), pairs.end(), [&](const ContactPair& p) { return !hangs(p); });
  const std::vector<ContactPair> hanging(first, pairs.end());
  pairs.erase(first, pairs.end());
  std::map<std::pair<int, int>, std::size_t> row_of;
  for (std::size_t i = 0; i < pairs.size(); ++i) row_of[{pairs[i].node_a, pairs[i].patch}] = i;
  std::map<std::size_t, RowSum> sums;
  for (const ContactPair& pair : hanging) {
    for (const auto& [node, weight] : fem::hanging_at(mesh_a, pair.node_a)->bearers()) {
      const auto [row, is_new] = row_of.insert({{node, pair.patch}, pairs.size()});
      RowSum& sum = sums[row->second];
      if (is_new) {
        pairs.push_back({.node_a = node, .patch = pair.patch, .b = {}, .distance_m = mesh_a.position[at(node)][0]});
      } else if (sum.area_m2 == 0.0) {
        sum.add(pairs[row->second].area_m2, pairs[row->second]);
      }
      sum.add(weight * pair.area_m2, pair);
    }
  }
  for (const auto& [row, sum] : sums) sum.take(mesh_a, mesh_b, pairs[row]);
}

}  // namespace ricochet::scene
