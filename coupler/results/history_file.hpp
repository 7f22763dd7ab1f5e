#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/base/write_file.hpp"
#include "common/problem/problem.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// What a scene has columns for.
struct HistoryShape {
  std::vector<std::string> bodies{};
  bool has_contact = false;             ///< else the gap is written as nan
  bool solid = false;                   ///< what lies along the binormal follows the bodies
  int angular = 0;                      ///< components of the angular momentum: of solids 3, in plane strain 1, about z
  bool round = false;                   ///< a contact has a radius: axisymmetric or solid
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
  /// Replaces the file, or goes on after its first `keep` bytes, which a run before wrote. Throws ConfigError if it
  /// cannot be written or is shorter than that.
  HistoryFile(std::string path, HistoryShape shape, std::int64_t keep = 0);
  HistoryFile(const HistoryFile&) = delete;
  HistoryFile& operator=(const HistoryFile&) = delete;
  ~HistoryFile();

  void add(HistoryRow row);
  void flush();
  /// Bytes of the file with all rows so far, which are flushed.
  [[nodiscard]] std::int64_t bytes();

 private:
  std::string path_;
  HistoryShape shape_;
  int descriptor_;
  std::string pending_;
  std::chrono::steady_clock::time_point flushed_;
};

}  // namespace ricochet::coupler
