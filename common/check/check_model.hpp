#pragma once

#include "common/check/check.hpp"

/// Words of `plan` on the limits of the model: small strain, small displacement, contact only where one is declared.
/// Internal to common/scene.
namespace ricochet::scene {

/// Bodies without a contact between them: throws ConfigError where two overlap at the start; warns where two meet on a
/// straight flight at their initial velocities, which bodies in contact leave when they first touch.
void check_overlaps(const Problem& problem, Plan& plan);

/// Warns if the nodes of two bodies that fly towards each other are no longer opposite when they touch: half an element
/// edge aside, or wholly past the other surface.
void check_slip_in_flight(const Problem& problem, Plan& plan);

}  // namespace ricochet::scene
