#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/own_files.hpp"
#include "common/base/window_clock.hpp"

namespace ricochet::coupler {

/// The fate of the files that former runs left.
enum class Former { removed, kept };

/// Where a run writes. Holds a lock as long as the run lasts (on the directory itself: no lock file that could become
/// stale), and removes what former runs wrote there. Files of others stay: OwnFiles.
class ResultsDirectory {
 public:
  /// Creates the directory. `names`: what is going to be written there, in the form of OwnFiles::claim. `inputs`: paths
  /// of what is read, which stays if it lies there. Throws ConfigError if that fails, another run is writing there, or
  /// a file of one of these names is somebody else's or an input; then nothing there is changed. `former`: kept where
  /// a run goes on, but for halves of files.
  ResultsDirectory(const std::string& path, const std::vector<std::string>& names,
                   const std::vector<std::string>& inputs = {}, Former former = Former::removed);
  ResultsDirectory(const ResultsDirectory&) = delete;
  ResultsDirectory& operator=(const ResultsDirectory&) = delete;
  ~ResultsDirectory();

  [[nodiscard]] const std::string& path() const { return path_; }  ///< absolute
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }
  /// Removes what is of later windows: checkpoints, and snapshots of participants; and halves of files, of processes
  /// that were killed while they wrote.
  void go_on_from(std::int64_t window, const std::vector<std::string>& participants) const;
  [[nodiscard]] std::string log(const std::string& participant) const { return file("logs/" + participant + ".log"); }

 private:
  void make_folder(const std::string& name);
  void remove_charts() const;
  std::string path_;
  int descriptor_ = -1;
  std::vector<std::string> made_;  ///< folders that were not there before
  std::unique_ptr<OwnFiles> own_;
};

/// The holder of the lock of a folder of results.
struct LockHolder {
  bool a_run = false;  ///< else a program of another kind, which writes nothing of ours
  std::string text;    ///< says so, with its process and, if that is another one, its user
};
/// Nothing if nobody does.
[[nodiscard]] std::optional<LockHolder> lock_holder(const std::string& path);

/// Writes what opens the files of fields that lie in fields/ (`field_name`) as one data set a time, if there are any:
/// fields/<name>_<window>.vtm has a block for each body, by its name and in the given order, with a data set for each
/// participant that integrates some of it; fields/<name>.pvd has the times. A .vtm of another window, which a run that
/// was resumed with another step left, is removed.
void write_collection(const ResultsDirectory& results, const std::string& name, const std::vector<std::string>& bodies,
                      const std::vector<std::string>& participants, const WindowClock& clock);

}  // namespace ricochet::coupler
