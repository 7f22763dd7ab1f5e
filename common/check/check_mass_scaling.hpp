#pragma once

#include "common/check/check.hpp"

namespace ricochet::scene {

/// Notes what mass scaling adds to each body, and warns where a contact feels it.
void check_mass_scaling(const Problem& problem, Plan& plan);

}  // namespace ricochet::scene
