#pragma once

#include "common/fem/part.hpp"

namespace ricochet::cost {

/// K u of a part on this machine, the least of some tries [s].
[[nodiscard]] double time_product(const fem::Part& part);

}  // namespace ricochet::cost
