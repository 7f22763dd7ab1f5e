#pragma once

#include "common/check/check.hpp"

/// The lines of `plan` on the contact. Internal to common/check.
namespace ricochet::scene {

/// Penalty against the step: fills the penalty members of the plan, warns, and throws ConfigError if central
/// difference with the penalty exceeds its critical step. Nothing to do for the multiplier.
void check_penalty(const Problem& problem, Plan& plan);

/// Refuses, with a ConfigError, a contact node of a solid with friction that a support holds along a coordinate askew
/// to n, t and b, under a law that goes by pairs of nodes.
void check_supports(const Problem& problem);

/// Warns where the regularised friction law rings: its velocity scale 1/xi below a tenth of mu N dt / (2 m), with N
/// from one-dimensional impact theory, p = v Z_a Z_b / (Z_a + Z_b).
void check_friction(const Problem& problem, Plan& plan);

/// The first impact, by one-dimensional theory at the initial velocities: warns where it strains a body by more than 2
/// %, and where a step moves the bodies together by more than half an element at the contact; throws ConfigError from a
/// whole element on, of which such a step leaves nothing.
void check_impact(const Problem& problem, Plan& plan);

}  // namespace ricochet::scene
