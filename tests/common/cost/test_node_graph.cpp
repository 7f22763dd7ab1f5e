#include <gtest/gtest.h>

#include "common/cost/node_graph.hpp"

namespace ricochet::cost {
namespace {

fem::Mesh bar_of(int elements) {
  std::vector<double> along;
  for (int i = 0; i <= elements; ++i) along.push_back(0.1 * i);
  return fem::bar_mesh(along);
}

NodeGraph whole(const fem::Mesh& mesh) { return node_graph(mesh, std::vector<bool>(mesh.elements.size(), true)); }

TEST(NodeGraph, HasTheNodesOfTheElementsAndTheirNeighbours) {
  const fem::Mesh mesh = fem::quadrilateral_mesh(fem::Model::plane_strain, {0.0, 1.0, 2.0}, {0.0, 1.0});
  const NodeGraph one = node_graph(mesh, {false, true});
  EXPECT_EQ(one.node, (std::vector<int>{1, 2, 4, 5}));
  EXPECT_EQ(one.neighbours.node.size(), 16U) << "four nodes, each with all of them";
  const NodeGraph both = whole(mesh);
  EXPECT_EQ(both.nodes(), 6);
  EXPECT_EQ(both.neighbours.node.size(), 4U * 4U + 2U * 6U) << "four corners, and two nodes that are in both elements";
}

TEST(NodeGraph, FactorHasTheEntriesOfADenseElementAndOfATridiagonalBar) {
  EXPECT_EQ(factor_size(whole(bar_of(50)), 1).entries, 51 + 50);
  const fem::Mesh element = fem::quadrilateral_mesh(fem::Model::plane_strain, {0.0, 1.0}, {0.0, 1.0});
  EXPECT_EQ(factor_size(whole(element), 2).entries, 8 * 9 / 2);
  EXPECT_EQ(factor_size(NodeGraph{}, 2).entries, 0);
}

TEST(NodeGraph, AWaveReachesOneMoreNodeInEveryStep) {
  const NodeGraph bar = whole(bar_of(4));
  EXPECT_DOUBLE_EQ(reached_share(bar, {0}, 3), (3 + 2 + 1) / (3 * 5.0));
  EXPECT_DOUBLE_EQ(reached_share(bar, {4, 0}, 3), 2 * (3 + 2) / (3 * 5.0) + 1 / (3 * 5.0)) << "they meet in the middle";
  EXPECT_DOUBLE_EQ(reached_share(bar, {2}, 1000), (1000 + 2 * 999 + 2 * 998) / (1000 * 5.0));
  EXPECT_EQ(reached_share(bar, {}, 10), 0.0) << "it flies";
}

}  // namespace
}  // namespace ricochet::cost
