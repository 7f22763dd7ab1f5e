#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "coupler/interface/peer.hpp"

namespace ricochet::coupler {

/// Names participants that leave history columns out without which a balance is none: a column that nobody tells counts
/// as zero, and the sum then accuses whoever is right. "participant 'x' (energy_strain_j/left)", with the first column
/// that is missing.
struct Untold {
  std::vector<std::string> energy;     ///< kinetic and strain energy, work of what loads a body, friction
  std::vector<std::string> momentum;   ///< along n, t and b, and the impulses of what holds or loads a body
  std::vector<std::string> interface;  ///< work of the links: who made energy
};

[[nodiscard]] Untold untold(const scene::Problem& problem, const std::vector<PeerDescription>& descriptions);

}  // namespace ricochet::coupler
