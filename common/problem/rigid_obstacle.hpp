#pragma once

#include <vector>

#include "common/problem/contact_side.hpp"

/// What is rigid and stands in a body's way. Internal to common/problem.
namespace ricochet::scene {

/// A pair for each node of the surface. A rigid plane touches it where it is farthest out.
[[nodiscard]] std::vector<ContactPair> rigid_pairs(const ContactContext& context, const ContactSide& side);

}  // namespace ricochet::scene
