#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/base/write_file.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {

/// Names of the columns of history.csv, units in the names; last, of a scene of solids, what lies along the binormal.
[[nodiscard]] std::vector<std::string> history_columns(const std::vector<std::string>& bodies, bool solid);

/// Writes history.csv: one line per merged row, numbers with 17 digits, so that equal runs give equal files.
/// Whole lines only reach the file, at least every 0.2 s, so that it can be read at any time and after any failure.
class HistoryFile {
 public:
  /// Replaces the file. `has_contact`: else the gap is written as nan. Throws ConfigError if it cannot be written.
  HistoryFile(std::string path, const std::vector<std::string>& bodies, bool has_contact, bool solid);
  HistoryFile(const HistoryFile&) = delete;
  HistoryFile& operator=(const HistoryFile&) = delete;
  ~HistoryFile();

  void add(HistoryRow row);
  void flush();

 private:
  std::string path_;
  bool has_contact_, solid_;
  int descriptor_;
  std::string pending_;
  std::chrono::steady_clock::time_point flushed_;
};

}  // namespace ricochet::coupler
