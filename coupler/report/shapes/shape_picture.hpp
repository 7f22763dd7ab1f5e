#pragma once

#include <optional>

#include "coupler/report/parts/chart.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/shapes/shape_files.hpp"

namespace ricochet::report {

/// The deformed bodies at a few times, coloured by stress; none if there is nothing to draw. `history`: for the contact
/// force, the first gap and which time is nearest to the largest force. `first_contact_s`: nan if there was none. The
/// picture is made of pixels, whatever the number of elements.
[[nodiscard]] std::optional<Chart> shape_picture(const Shapes& shapes, const HistoryTable& history,
                                                 double first_contact_s);

}  // namespace ricochet::report
