#pragma once

#include "common/fem/part.hpp"

namespace ricochet::cost {

/// K u of a part on this machine, the least of some tries [s].
[[nodiscard]] double time_product(const fem::Part& part);

/// A number that is in no cache, of many in a row [s]. Found once, in some 60 ms.
[[nodiscard]] double memory_read_s();

}  // namespace ricochet::cost
