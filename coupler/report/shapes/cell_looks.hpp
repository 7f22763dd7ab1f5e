#pragma once

#include <array>
#include <vector>

#include "coupler/report/shapes/shape_files.hpp"

namespace ricochet::report {

enum class EdgeKind : unsigned char { none, inner, outline };

/// How each cell of each piece is drawn, apart from where it is.
struct CellLook {
  bool hidden = false;              ///< the face of a solid that another piece of the same body has, too
  std::array<EdgeKind, 4> edges{};  ///< from corner i to the next
};
/// Outlines are edges that one cell of a body has alone; of a solid those where faces meet at more than 30 degrees.
[[nodiscard]] std::vector<std::vector<CellLook>> cell_looks(const Shapes& shapes);

}  // namespace ricochet::report
