#pragma once

#include <string>

#include "common/problem/problem.hpp"

/// Internal to common/check, but for is_to_switch.
namespace ricochet::scene {

/// Whether the implicit participant is to integrate explicitly after separation, if it can.
[[nodiscard]] bool is_to_switch(const Problem& problem);

/// Why the implicit participant cannot integrate explicitly after separation though the scene leaves that to it; empty:
/// it can, or the scene or its protocol never asks it to. From then on explicit and implicit elements are one mesh that
/// central difference integrates with the lumped masses of all of them, so its limit is 2/omega_max(K, M) of the whole
/// body: below that of the explicit elements alone, whose shared nodes have the mass of both sides but the stiffness of
/// one.
[[nodiscard]] std::string switch_obstacle(const Problem& problem);

}  // namespace ricochet::scene
