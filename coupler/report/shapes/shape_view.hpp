#pragma once

#include <span>
#include <string>
#include <vector>

#include "coupler/report/shapes/canvas.hpp"
#include "coupler/report/shapes/shape_files.hpp"

namespace ricochet::report {

enum class EdgeKind : unsigned char { none, inner, outline };

/// What is to be drawn of each cell of each piece, apart from where it is.
struct CellLook {
  bool hidden = false;              ///< the face of a solid that another piece of the same body has, too
  std::array<EdgeKind, 4> edges{};  ///< from corner i to the next
};
/// Outlines are edges that one cell of a body has alone; of a solid those where faces meet at more than 30 degrees.
[[nodiscard]] std::vector<std::vector<CellLook>> cell_looks(const Shapes& shapes);

/// A cell as it is seen.
struct SeenCell {
  std::array<Pixel, 4> corner{};  ///< to the right and up [m]
  std::size_t count = 0;          ///< of its corners
  std::array<EdgeKind, 4> edges{};
  double depth_m = 0.0;  ///< towards the reader
  int shade = 0;
  double stress_pa = 0.0;
  int body = 0;

  [[nodiscard]] std::span<const Pixel> corners() const { return {corner.data(), count}; }
};

/// From where a model is looked at. Bars, plane strain and axisymmetry: at their plane, of axisymmetry at both halves
/// of the section; solids: from aside and above, as a parallel projection.
class ShapeView {
 public:
  /// `turned`: the last coordinate points to the right instead of up.
  ShapeView(std::string model, bool turned);

  /// Cells of a piece at these places of its nodes. `strip_m`: of a bar.
  void add(const ShapePiece& piece, const std::vector<Place>& places, const std::vector<CellLook>& looks,
           std::size_t window, double strip_m, std::vector<SeenCell>& cells) const;
  /// A mirrored picture's other half of a place that is seen.
  [[nodiscard]] Pixel mirror_image(const Pixel& seen) const;
  /// Where a place is seen [m].
  [[nodiscard]] Pixel seen(const Place& x) const;
  struct Axis {
    std::string letter;
    Pixel direction;  ///< to the right and up, per metre along it
  };
  [[nodiscard]] std::vector<Axis> axes() const;
  [[nodiscard]] bool mirrored() const { return model_ == "axisymmetric"; }
  [[nodiscard]] bool turned() const { return turned_; }

 private:
  std::string model_;
  bool turned_;
  Place right_{}, up_{}, towards_{};
};

}  // namespace ricochet::report
