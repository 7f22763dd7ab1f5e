#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "coupler/history.hpp"

namespace ricochet::coupler {

/// Names of the columns of history.csv, units in the names.
[[nodiscard]] std::vector<std::string> history_columns(const std::vector<std::string>& bodies);

/// Writes history.csv: one line per merged row, numbers with 17 digits, so that equal runs give equal files.
/// Whole lines only reach the file, at least every 0.2 s, so that it can be read at any time and after any failure.
class HistoryFile {
 public:
  /// Replaces the file. `has_contact`: else the gap is written as nan. Throws ConfigError if it cannot be written.
  HistoryFile(std::string path, const std::vector<std::string>& bodies, bool has_contact);
  HistoryFile(const HistoryFile&) = delete;
  HistoryFile& operator=(const HistoryFile&) = delete;
  ~HistoryFile();

  void add(const HistoryRow& row);
  void flush();

 private:
  std::string path_;
  bool has_contact_;
  int descriptor_;
  std::string pending_;
  std::chrono::steady_clock::time_point flushed_;
};

/// Writes a whole file under a temporary name and renames it: readers see the old or the new one, never half of it.
void write_atomically(const std::string& path, const std::string& text);

}  // namespace ricochet::coupler
