// Nodes and the ranks that step them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/body/blocks.hpp"
#include "explicit_solver/ranks/shares.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::explicit_solver {
namespace {

struct Block {
  scene::Problem problem;
  std::vector<solver::BodyState> whole;

  /// Elements along each edge.
  explicit Block(int across, int along) {
    const test::TemporaryFolder folder;
    problem = scene::build_problem(scene::load_scene(folder.write(fmt::format(R"(model = "solid"
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }}
mesh = {{ length_m = 0.1, height_m = 0.1, width_m = 0.1, elements = [{0}, {0}, {1}] }}
[contact]
surfaces = ["block.start", "rigid_plane"]
[partition]
implicit_length_m = {{ block = 0.02 }}
[[participant]]
name = "explicit"
role = "explicit"
bodies = ["block"]
[[participant]]
name = "implicit"
role = "implicit"
[time]
safety_factor = 0.8
end_s = 1.0
)",
                                                                              across, along))));
    whole = solver::initial_states(problem, problem.scene.participant("explicit"), false);
  }
};

TEST(Shares, EveryNodeIsOneRanks) {
  const Block block(12, 24);
  const auto& part = block.whole.front().part;
  for (const int ranks : {1, 2, 3, 4, 7}) {
    const auto shared = share_out(block.problem, block.whole, {}, 1, ranks).front();
    std::vector<int> owners(part.body_node.size(), 0);
    for (int rank = 0; rank < ranks; ++rank) {
      const auto own = part_of_rank(block.problem, block.problem.scene.participant("explicit"), shared, rank);
      int count = 0;
      for (int node = 0; node < own.part.nodes(); ++node) {
        if (!own.own[static_cast<std::size_t>(node)]) continue;
        ++count;
        ++owners[static_cast<std::size_t>(own.numbering.number[static_cast<std::size_t>(node)])];
      }
      EXPECT_LT(count, 1.25 * part.nodes() / ranks + solver::block_nodes) << "rank " << rank << " of " << ranks;
      EXPECT_GT(count, 0) << "rank " << rank << " of " << ranks;
    }
    EXPECT_THAT(owners, testing::Each(1)) << ranks << " ranks";
  }
}

/// The contact alone is more than a share; the others share the rest.
TEST(Shares, WhatTheFirstRankMustHaveIsAllItGets) {
  const Block block(12, 12);
  const auto& part = block.whole.front().part;
  constexpr int ranks = 12, layer = 13 * 13;
  const auto shared = share_out(block.problem, block.whole, {}, 1, ranks).front();
  std::vector<int> nodes(ranks, 0);
  for (int node = 0; node < part.nodes(); ++node) ++nodes[static_cast<std::size_t>(shared.rank_of(node))];
  EXPECT_GT(nodes[0], part.nodes() / ranks);
  EXPECT_LE(nodes[0], 2 * layer + 3 * solver::block_nodes);
  for (int rank = 1; rank < ranks; ++rank)
    EXPECT_NEAR(nodes[static_cast<std::size_t>(rank)], (part.nodes() - nodes[0]) / (ranks - 1),
                2 * solver::block_nodes);
}

/// Complete rows: the same entries as in the whole part's, of the same neighbours, and nothing in the others.
TEST(Shares, RowsOfOwnNodesAreThoseOfTheWhole) {
  const Block block(3, 9);
  const auto& whole = block.whole.front().part;
  const auto shared = share_out(block.problem, block.whole, {}, 1, 3).front();
  for (int rank = 0; rank < 3; ++rank) {
    const auto own = part_of_rank(block.problem, block.problem.scene.participant("explicit"), shared, rank);
    const auto& number = own.numbering.number;
    for (int row = 0; row < own.part.dofs(); ++row) {
      std::map<int, double> expected, found;
      for (fem::SparseMatrix::InnerIterator it(own.part.stiffness, row); it; ++it)
        found[3 * number[static_cast<std::size_t>(it.col() / 3)] + static_cast<int>(it.col() % 3)] = it.value();
      const int whole_row = 3 * number[static_cast<std::size_t>(row / 3)] + row % 3;
      if (own.own[static_cast<std::size_t>(row / 3)]) {
        for (fem::SparseMatrix::InnerIterator it(whole.stiffness, whole_row); it; ++it)
          expected[static_cast<int>(it.col())] = it.value();
        EXPECT_EQ(own.part.lumped_mass[row / 3], whole.lumped_mass[whole_row / 3]);
      }
      ASSERT_EQ(found, expected) << "row " << row << " of rank " << rank;
    }
  }
}

/// All that the link moves, and all that reads it, is the first rank's.
TEST(Shares, TheFirstRankHasTheInterface) {
  const Block block(6, 12);
  const auto& state = block.whole.front();
  ASSERT_FALSE(state.shared_nodes.empty());
  const auto shared = share_out(block.problem, block.whole, {}, 1, 4).front();
  for (const int node : state.shared_nodes) {
    for (fem::SparseMatrix::InnerIterator it(state.part.stiffness, 3 * node); it; ++it)
      EXPECT_EQ(shared.rank_of(static_cast<int>(it.col()) / 3), 0);
  }
}

/// Between ranks there is no more than a cut through the block.
TEST(Shares, FewElementsLieBetweenRanks) {
  const Block block(12, 48);
  const auto shared = share_out(block.problem, block.whole, {}, 1, 2).front();
  int between = 0;
  for (const auto& element : block.whole.front().part.mesh.elements) {
    std::set<int> ranks;
    for (const int node : element) ranks.insert(shared.rank_of(node));
    between += ranks.size() > 1 ? 1 : 0;
  }
  EXPECT_LE(between, 3 * 12 * 12) << "blocks of nodes make the cut uneven";
}

}  // namespace
}  // namespace ricochet::explicit_solver
