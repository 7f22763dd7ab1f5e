#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "explicit_solver/block_sums.hpp"
#include "explicit_solver/ranks.hpp"
#include "explicit_solver/ranks/communicator.hpp"
#include "explicit_solver/ranks/shares.hpp"
#include "explicit_solver/stepping.hpp"

namespace ricochet::explicit_solver {

/// One rank's share of all parts, and how it talks of each to the others.
class RankShare {
 public:
  RankShare(const scene::Problem& problem, const scene::ParticipantSpec& participant,
            const std::vector<SharedPart>& shared, participant::Drive driven_by, Communicator& communicator);
  RankShare(const RankShare&) = delete;
  RankShare& operator=(const RankShare&) = delete;

  [[nodiscard]] std::vector<solver::BodyState>& states() { return states_; }
  /// This rank's share of the whole, part by part: u, v and a of its own nodes and, of a part that yields, what the
  /// elements of its own blocks remember; sums of its own blocks and the largest plastic strain and temperature.
  [[nodiscard]] std::vector<double> motion() const;
  [[nodiscard]] std::vector<double> sums(const Stepping& stepping) const;
  /// On the first rank, of whole parts: in which order what is booked comes in.
  void book_for(const std::vector<solver::BodyState>& whole, const std::vector<SharedPart>& shared);

 private:
  class Neighbours;
  std::vector<solver::BodyState> states_;
  std::vector<std::vector<int>> own_dofs_, own_blocks_;  ///< per part
  std::vector<std::shared_ptr<Neighbours>> neighbours_;  ///< per part; states_ point to them
};

/// The first rank begins with it, and the others hear of it: what Stepping needs of a setup, and who steps what.
struct Beginning {
  participant::Setup setup;
  std::vector<SharedPart> shared;

  void archive(Archive& a) { a(setup.clock, setup.substeps, setup.driven_by, shared); }
};

/// The word of the first rank to the others.
struct Command {
  std::int64_t window = 0;
  int substep = 0;
  Order order = Order::end;
};

/// The work of a rank that is not the first until it is told to end: from the beginning on, of which it hears `said`.
void follow(const scene::Problem& problem, const std::string& participant, const std::string& said,
            Communicator& communicator);

}  // namespace ricochet::explicit_solver
