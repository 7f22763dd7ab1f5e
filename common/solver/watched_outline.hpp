#pragma once

#include <vector>

#include "common/body/body_state.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::solver {

/// The outline nodes of this participant's bodies that others could meet where no contact holds them apart: what the
/// coupler, which alone knows all bodies, watches.
class WatchedOutline {
 public:
  WatchedOutline() = default;  ///< nothing
  WatchedOutline(const scene::Problem& problem, const std::vector<BodyState>& states);

  [[nodiscard]] std::vector<participant::OutlineNode> nodes(const std::vector<BodyState>& states) const;

 private:
  struct Node {
    std::size_t part = 0;
    int local = 0;
  };
  std::vector<Node> nodes_;
};

}  // namespace ricochet::solver
