#pragma once

#include <string>
#include <vector>

namespace ricochet::coupler {

/// Where a run writes. Holds a lock as long as the run lasts (on the directory itself: no lock file that could become
/// stale), and removes what a former run left under the names that this one writes.
class ResultsDirectory {
 public:
  /// Creates the directory. Throws ConfigError if that fails or another run is writing there.
  explicit ResultsDirectory(const std::string& path);
  ResultsDirectory(const ResultsDirectory&) = delete;
  ResultsDirectory& operator=(const ResultsDirectory&) = delete;
  ~ResultsDirectory();

  [[nodiscard]] const std::string& path() const { return path_; }  ///< absolute
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }
  [[nodiscard]] std::string log(const std::string& participant) const { return file("logs/" + participant + ".log"); }

 private:
  void remove_former_results() const;
  std::string path_;
  int descriptor_;
};

/// Writes fields/<name>.pvd: the snapshots "<participant>_<window>.vtu" found in fields/, grouped by time, one part per
/// participant in the given order. Does nothing if there are none.
void write_pvd(const ResultsDirectory& results, const std::string& name, const std::vector<std::string>& participants,
               double window_size_s);

}  // namespace ricochet::coupler
