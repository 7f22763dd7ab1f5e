#pragma once

#include <string>
#include <vector>

#include "common/problem/contact_side.hpp"

/// Pairs of two bodies' surfaces: nodes that lie opposite each other, or rows of the dual mortar. Internal to
/// common/problem.
namespace ricochet::scene {

/// Sets pairs of nodes where they match, else rows of the dual mortar; where surfaces are curved, at the place where
/// they touch. Bodies that may slide have what rows are written anew from, too.
void set_pairs(const ContactContext& context, const ContactSide& a, const ContactSide& b, ContactGeometry& geometry);

/// Both are flat and their nodes lie opposite each other.
[[nodiscard]] bool match_in_pairs(const ContactSide& a, const ContactSide& b);
/// Laws that move masses or weigh by impedances go by pairs of nodes.
[[nodiscard]] bool needs_pairs(const Scene& scene);
/// Refuses what has no node opposite, under a law that needs one.
void require_matching(const ContactContext& context, std::vector<std::string> lonely);

/// Sets what a pair's node says, and its gap, the surfaces being apart along the normal by `apart_m`.
void complete(const Contact& contact, const fem::Mesh& mesh_a, double apart_m, ContactPair& pair);
/// A hanging node has no force of its own: the row of one of the first surface goes to its carriers, by its shares, and
/// what it weighs of the second to theirs. A carrier's row becomes the mean of those, by their areas, gap and normal
/// too: its force does the work that theirs, shared out like this, would do. `mesh_b` is null for what is rigid.
void carry(const fem::Mesh& mesh_a, const fem::Mesh* mesh_b, std::vector<ContactPair>& pairs);
void sort_by_distance(std::vector<ContactPair>& pairs);

}  // namespace ricochet::scene
