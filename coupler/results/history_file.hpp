#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/base/sha256.hpp"
#include "common/problem/problem.hpp"
#include "coupler/results/checkpoint.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// What a scene has columns for.
struct HistoryShape {
  std::vector<std::string> bodies{};
  bool has_contact = false;             ///< else the gap is written as nan
  bool solid = false;                   ///< what lies along the binormal follows the bodies
  int angular = 0;                      ///< components of the angular momentum: of solids 3, in plane strain 1, about z
  bool round = false;                   ///< a contact has a radius: axisymmetric or solid
  bool yields = false;                  ///< a body has a material with plasticity
  std::vector<std::string> contacts{};  ///< of several: what is told of each comes last
};
/// Components of the angular momentum that a scene has: none about an axis of symmetry, of bars, and where meshes
/// repeat.
[[nodiscard]] int angular_components(const scene::Problem& problem);
[[nodiscard]] HistoryShape history_shape(const scene::Problem& problem);

/// Names of the columns of history.csv, units in the names.
[[nodiscard]] std::vector<std::string> history_columns(const HistoryShape& shape);

/// Writes history.csv: one line per merged row, numbers with 17 digits, so that equal runs give equal files.
/// Whole lines only reach the file, at least every 0.2 s, so that it can be read at any time and after any failure.
class HistoryFile {
 public:
  /// Replaces the file, or goes on after the beginning `keep`, which a run before wrote. Throws ConfigError if it
  /// cannot be written, is no regular file, or does not begin so.
  HistoryFile(std::string path, HistoryShape shape, const Beginning& keep = {});
  HistoryFile(const HistoryFile&) = delete;
  HistoryFile& operator=(const HistoryFile&) = delete;
  ~HistoryFile();

  void add(HistoryRow row);
  void flush();
  /// The file with all rows so far, which are flushed.
  [[nodiscard]] Beginning so_far();

 private:
  std::string path_;
  HistoryShape shape_;
  int descriptor_;
  Sha256 digest_;  ///< of what is written
  std::string pending_;
  std::chrono::steady_clock::time_point flushed_;
};

}  // namespace ricochet::coupler
