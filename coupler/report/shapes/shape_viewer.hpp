#pragma once

#include <optional>
#include <string>

#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/shapes/shape_files.hpp"

namespace ricochet::report {

/// The deformed bodies, which viewer.js draws with three.js.
struct ShapeViewer {
  std::string html;     ///< the figure that it is drawn into, with title and note
  std::string scripts;  ///< three.js, the bodies as JSON, viewer.js
  Json data;            ///< these bodies, see data_of
};

/// None if there is nothing to draw. `history`: for the first gap.
/// `first_contact_s`: nan if there was none.
[[nodiscard]] std::optional<ShapeViewer> shape_viewer(const Shapes& shapes, const HistoryTable& history,
                                                      double first_contact_s);

}  // namespace ricochet::report
