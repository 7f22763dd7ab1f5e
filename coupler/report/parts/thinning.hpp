#pragma once

#include <cstddef>
#include <vector>

namespace ricochet::report {

/// Rows of a history that suffice to draw it `pixels` wide, ascending: of every pixel column the first and last row and
/// those with the smallest and largest value of each series; so no peak is lost and the drawn line covers the same
/// pixels (M4 aggregation: Jugel, Jerzak, Hackenbroich, Markl, PVLDB 7(10), 2014). Pixel column of a row:
/// floor(pixels (t - t_first)/(t_last - t_first)). The first value of a pixel column that is not finite is kept,
/// so that the line breaks there. `time` ascends; all series have its length.
[[nodiscard]] std::vector<std::size_t> thin(const std::vector<double>& time,
                                            const std::vector<const std::vector<double>*>& series, std::size_t pixels);

}  // namespace ricochet::report
