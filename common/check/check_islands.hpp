#pragma once

#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Implicit elements of a body that hang together by nodes and touch neither a contact surface nor a foreign body: the
/// automatic partition made them implicit for their own critical step alone.
struct Islands {
  int body = 0;
  double step_s = 0.0;              ///< an element with a critical step below this one is implicit
  std::vector<int> elements;        ///< of each island
  int nodes = 0, shared_nodes = 0;  ///< of all islands; those that explicit elements have, too
  int slivers = 0;                  ///< islands of fewer than sliver_elements
  /// Among the slivers, if there are any, else of all islands: the elements of least critical step, at most five,
  /// ascending, and their steps [s].
  std::vector<int> shortest;
  std::vector<double> shortest_s;
};

/// Per body that has some; none unless `partition.rule = "auto"` couples two sides.
[[nodiscard]] std::vector<Islands> islands_of(const Problem& problem);

/// A line each: how many, where, how short, what they share, and what to do.
[[nodiscard]] std::string text_of(const Problem& problem, const Islands& islands);

}  // namespace ricochet::scene
