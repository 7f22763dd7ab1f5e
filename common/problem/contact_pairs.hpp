#pragma once

#include <string>
#include <vector>

#include "common/problem/contact_side.hpp"

/// Pairs of two bodies' surfaces: nodes that lie opposite each other, or rows of the dual mortar. Internal to
/// common/problem.
namespace ricochet::scene {

/// Pairs of nodes where they match, else rows of the dual mortar.
[[nodiscard]] std::vector<ContactPair> pairs_of(const ContactContext& context, const ContactSide& a,
                                                const ContactSide& b);

/// What rows of two surfaces are written from, wherever the second has got to.
[[nodiscard]] ContactMesh mesh_of(const ContactSide& a, const ContactSide& b);

/// Laws that move masses or weigh by impedances go by pairs of nodes.
[[nodiscard]] bool needs_pairs(const Scene& scene);
/// Refuses what has no node opposite, under a law that needs one.
void require_matching(const ContactContext& context, std::vector<std::string> lonely);

/// Sets what a pair's node says, and its gap, the surfaces being apart along the normal by `apart_m`.
void complete(const Contact& contact, const fem::Mesh& mesh_a, double apart_m, ContactPair& pair);
void sort_by_distance(std::vector<ContactPair>& pairs);

}  // namespace ricochet::scene
