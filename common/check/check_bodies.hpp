#pragma once

#include "common/check/check.hpp"

/// The lines of `plan` on each body as a whole. Internal to common/check.
namespace ricochet::scene {

/// Mass, size, speed and energy of each body at the start.
[[nodiscard]] std::vector<BodyPlan> plan_bodies(const Problem& problem);

/// Warns of bodies that look as if they were given in another unit than SI's: materials with the wave speed or the
/// density of none, and bodies so large that no wave crosses a twentieth of them in the run, or of tens of tonnes from
/// a mesh file.
void check_units(const Problem& problem, Plan& plan);

/// Notes which cards of .inp files say nothing about a mesh and are left out, each file once.
void note_ignored_cards(const Scene& scene, Plan& plan);

/// Notes ties where nodes of the finer surface lie beside the other one.
void note_partial_ties(const Problem& problem, Plan& plan);

}  // namespace ricochet::scene
