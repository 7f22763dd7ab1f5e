#pragma once

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// 2h/c [s]: how long a wave of speed c takes through an element of depth h at the contact and back, the longest of
/// the nodes of both surfaces. A mesh resolves nothing shorter: what the force is within it, right after an impact, is
/// the mass of the contact nodes over the step. 0 without pairs.
[[nodiscard]] double rise_time_s(const Problem& problem, const ContactGeometry& contact);
/// The longest of all contacts.
[[nodiscard]] double rise_time_s(const Problem& problem);

}  // namespace ricochet::scene
