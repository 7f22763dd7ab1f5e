#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/base/sha256.hpp"
#include "coupler/results/beginning.hpp"

namespace ricochet::coupler {

/// A table that grows during a run: one line per row, numbers with 17 digits, so that equal runs give equal files.
/// Whole lines only reach the file, at least every 0.2 s, so that it can be read at any time and after any failure.
class RowFile {
 public:
  /// Replaces the file, or goes on after the beginning `keep`, which a run before wrote. Throws ConfigError if it
  /// cannot be written, is no regular file, or does not begin so.
  RowFile(std::string path, const std::vector<std::string>& columns, const Beginning& keep);
  RowFile(const RowFile&) = delete;
  RowFile& operator=(const RowFile&) = delete;
  ~RowFile();

  /// The next number of the row.
  void put(double value);
  void end_row();
  void flush();
  /// The file with all rows so far, which are flushed.
  [[nodiscard]] Beginning so_far();

 private:
  std::string path_;
  int descriptor_;
  Sha256 digest_;  ///< of what is written
  std::string pending_;
  bool row_begun_ = false;
  std::chrono::steady_clock::time_point flushed_;
};

}  // namespace ricochet::coupler
