#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// The lines of `check` on the ends of bodies that a contact hears nothing of before `time.end_s`, a line each; nothing
/// where it hears of everything. A wave starts at a contact surface when the bodies have met and has to come back, or
/// at loaded, prescribed and stopped surfaces at t = 0, and runs along the axis with the fastest speed there is: the
/// dilatational one, in bars sqrt(E/rho).
[[nodiscard]] std::vector<std::string> unreached_ends(const Problem& problem);

/// When the two bodies of a contact, which only fly until then, first touch; 0 where they do more than fly, infinity
/// if they never touch [s].
[[nodiscard]] double first_contact_s(const Problem& problem, const ContactGeometry& contact);
/// The first of all contacts.
[[nodiscard]] double first_contact_s(const Problem& problem);

}  // namespace ricochet::scene
