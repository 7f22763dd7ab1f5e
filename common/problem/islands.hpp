#pragma once

#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Implicit elements of a body that hang together by nodes and touch neither a contact surface nor a foreign body, one
/// list for each such island, in the order of their first elements.
[[nodiscard]] std::vector<std::vector<int>> elements_of_islands(const Problem& problem, int body);

/// Islands of fewer elements are slivers: bad ones of a mesh, not a zone that was made fine.
constexpr std::size_t sliver_elements = 10;

/// A window may be so many times as long as the step of an element that takes several steps in it; what is finer is
/// better off implicit.
constexpr double finest_explicit = 8.0;

/// Gives slivers, and islands that are not that fine, back to the explicit side, where they take several steps in a
/// window if they need some (BodyProblem::small_steps). They share no node with what stays implicit. One with a node of
/// a dashpot stays, whose force is that of whole windows. Nothing happens where the explicit side is no program of
/// ours, has groups, ranks, substeps or other steps later, is driven by force, or where the body turns.
void release_islands(Problem& problem, int body);

}  // namespace ricochet::scene
