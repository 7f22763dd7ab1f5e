#pragma once

#include <string>

#include "common/problem/problem.hpp"

namespace ricochet::coupler {

/// The rigid obstacles in a run's pictures, as text of fields/obstacles.json: of each obstacle its name, its places
/// [m], the width `strip_m` of a bar's plate, and cells as indices into the places, -1 beyond the two to four of a cell
/// (scene::DrawnObstacle). Empty where no contact has an obstacle.
[[nodiscard]] std::string obstacles_text(const scene::Problem& problem);

}  // namespace ricochet::coupler
