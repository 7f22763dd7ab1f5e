#pragma once

#include <optional>
#include <vector>

#include "common/base/archive.hpp"
#include "common/body/body_state.hpp"
#include "common/fem/local_steps.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::explicit_solver {

/// Says which rank steps which nodes of one part.
struct SharedPart {
  int body = -1;                   ///< index into Problem::bodies
  std::vector<int> nodes;          ///< of the whole part, as the body numbers them, ascending
  std::vector<int> rank_of_block;  ///< of each `block_nodes` nodes in a row
  bool loaded = false;             ///< a load acts somewhere in it
  bool slides = false;             ///< it may slide along another, and the first rank enforces the contact
  int booked = 0;                  ///< degrees of freedom at which something outside acts
  std::optional<solver::PartFrame::Whole> frame{};  ///< of a part that turns

  [[nodiscard]] int rank_of(int node) const;  ///< of a node of the whole part
  void archive(Archive& a) { a(body, nodes, rank_of_block, loaded, slides, booked, frame); }
};

/// The nodes of an element and those that its hanging nodes follow; one may come more than once.
[[nodiscard]] std::vector<int> moved_by(const fem::Mesh& mesh, const fem::Element& element);

/// Shares out the nodes of each part in blocks, by METIS on the graph of the blocks: about as many nodes to each rank,
/// with few elements between ranks (Karypis, Kumar: A fast and high quality multilevel scheme for partitioning
/// irregular graphs, SIAM J. Sci. Comput. 20, 1998). The first rank has all shared and contact nodes and those that
/// small steps reach, and what is within `layers` layers of elements of them, 1 or more: nobody else reads those.
/// `steps`: per part, or empty; rows that they multiply anew count as nodes.
[[nodiscard]] std::vector<SharedPart> share_out(const scene::Problem& problem,
                                                const std::vector<solver::BodyState>& whole,
                                                const std::vector<fem::LocalSteps>& steps, int layers, int ranks);

/// The share of a part that rank `rank` has.
[[nodiscard]] scene::ParticipantPart part_of_rank(const scene::Problem& problem,
                                                  const scene::ParticipantSpec& participant, const SharedPart& shared,
                                                  int rank);

}  // namespace ricochet::explicit_solver
