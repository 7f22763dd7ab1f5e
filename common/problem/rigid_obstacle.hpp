#pragma once

#include "common/problem/contact_side.hpp"

/// All that is rigid and stands in a body's way. Internal to common/problem.
namespace ricochet::scene {

/// A pair for each node of the surface, of a round obstacle for those that it is opposite to. It touches the surface,
/// but for the initial gap: a plane where the surface is farthest out. A pair's normal is the obstacle's own at the
/// place that is nearest to the node when they touch, and its gap the distance to it. A round one has its middle, too.
void set_rigid_pairs(const ContactContext& context, const ContactSide& side, ContactGeometry& geometry);

}  // namespace ricochet::scene
