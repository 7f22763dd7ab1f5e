#pragma once

#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// The layer of elements at the contact nodes, and elements that a window of `step_s` is too long for where what is
/// explicit would not bear it. The largest frequency of an assembly is bounded by
///   omega^2 <= max over nodes n of  sum_e m_en omega_e^2 / sum_e m_en,
/// omega_e being that of element e alone and m_en its lumped mass at n, since v . K_e v <= omega_e^2 v . M_e v. A bad
/// element of a mesh is small, so it weighs little among its neighbours and mostly stays explicit.
[[nodiscard]] std::vector<bool> automatic_elements(const BodyProblem& body, const std::vector<int>& contact,
                                                   double step_s);

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
/// ours, has groups, substeps or other steps later, is driven by force, or has ranks and the body turns; and in a scene
/// without contact, whose fine part then is what the hybrid is for.
void release_islands(Problem& problem, int body);

}  // namespace ricochet::scene
