#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/base64.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/shapes/cell_looks.hpp"
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

/// The figure that viewer.js draws into; title and note are plain text.
[[nodiscard]] std::string viewer_figure(const std::string& title, const std::string& note);
/// three.js, `data` for it, viewer_bodies.js and viewer.js, which say what `data` holds.
[[nodiscard]] std::string viewer_scripts(const Json& data);

/// Numbers as they lie in memory, in base64.
template <class Number>
Json packed(const std::vector<Number>& values) {
  return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)});
}
/// {"body", "cell": four int32 each, "edge": four bytes each (0 none, 1 inner, 2 outline)}. Faces that nobody sees are
/// left out.
[[nodiscard]] Json cells_data(const ShapePiece& piece, const std::vector<CellLook>& looks);
/// As many numbers of each as the model has components.
[[nodiscard]] std::vector<float> node_places(const Shapes& shapes, const std::vector<Place>& places);

}  // namespace ricochet::report
