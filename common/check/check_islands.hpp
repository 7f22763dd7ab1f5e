#pragma once

#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Implicit elements of a body that hang together by nodes and touch neither a contact surface nor a foreign body: the
/// automatic partition made them implicit for their own critical step alone.
struct Islands {
  int body = 0, islands = 0, elements = 0;
  int nodes = 0, shared_nodes = 0;  ///< of them; those that explicit elements have, too
  std::vector<int> shortest;        ///< the elements of least critical step, at most five, ascending
  std::vector<double> shortest_s;   ///< their steps
  /// Single bad elements of a mesh, not a zone that somebody made fine.
  [[nodiscard]] bool slivers() const { return elements < sliver_elements * islands; }
  static constexpr int sliver_elements = 10;
};

/// Per body that has some; none unless `partition.rule = "auto"` couples two sides.
[[nodiscard]] std::vector<Islands> islands_of(const Problem& problem);

/// A line each: how many, where, how short, what they share, and what to do.
[[nodiscard]] std::string text_of(const Problem& problem, const Islands& islands);

}  // namespace ricochet::scene
