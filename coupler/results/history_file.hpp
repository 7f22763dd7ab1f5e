#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "coupler/results/history.hpp"
#include "coupler/results/row_file.hpp"

namespace ricochet::coupler {

/// The parts of a scene that have columns.
struct HistoryShape {
  std::vector<std::string> bodies{};
  bool has_contact = false;             ///< else the gap is written as nan
  bool solid = false;                   ///< what lies along the binormal follows the bodies
  int angular = 0;                      ///< components of the angular momentum: of solids 3, in plane strain 1, about z
  bool round = false;                   ///< a contact has a radius: axisymmetric or solid
  bool yields = false;                  ///< a body has a material with plasticity
  bool heats = false;                   ///< plastic work heats a body
  bool reduced = false;                 ///< a body is reduced to modes
  std::vector<std::string> contacts{};  ///< of several: what is told of each comes last
};
/// Components of the angular momentum that a scene has: none about an axis of symmetry, of bars, where meshes
/// repeat, and with a rigid body that supports keep from turning.
[[nodiscard]] int angular_components(const scene::Problem& problem);
[[nodiscard]] HistoryShape history_shape(const scene::Problem& problem);

/// Names of the columns of history.csv, units in the names.
[[nodiscard]] std::vector<std::string> history_columns(const HistoryShape& shape);

/// Writes history.csv: one line per merged row.
class HistoryFile {
 public:
  /// See RowFile.
  HistoryFile(std::string path, HistoryShape shape, const Beginning& keep = {});

  void add(HistoryRow row);
  void flush() { rows_.flush(); }
  /// The file with all rows so far, which are flushed.
  [[nodiscard]] Beginning so_far() { return rows_.so_far(); }

 private:
  HistoryShape shape_;
  RowFile rows_;
};

}  // namespace ricochet::coupler
