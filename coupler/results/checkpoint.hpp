#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/computer.hpp"
#include "common/base/window_clock.hpp"
#include "coupler/results/beginning.hpp"

namespace ricochet::coupler {

/// All that a process set goes on from: one cut through the coupler and every participant at the same accepted window.
struct Checkpoint {
  std::string scene_path, scene_sha256, protocol;
  std::int64_t window = 0;
  double time_s = 0;                             ///< at the end of that window
  Beginning history, probes, fields;             ///< history.csv, probes.csv, the list of FieldDigests up to here
  double wall_s = 0, cpu_s = 0, stepping_s = 0;  ///< spent so far
  std::string coupler;                           ///< its part
  struct Part {
    std::string participant, bytes;
  };
  std::vector<Part> parts;
  bool by_this_user = false;  ///< of one that was read: this user's key signed it
  Computer computer{};        ///< of one that was read: of the coupler that wrote it
};

/// The sizes of windows so far, with which the coupler's part begins.
inline void read_clock(const Checkpoint& from, WindowClock& clock) {
  Archive in(from.coupler, "the coupler's part of the checkpoint");
  in(clock);
}

/// The folder `checkpoint` of a run's results. A cut is a file WINDOW.state of the coupler, one WINDOW.NAME.state of
/// each participant, and last of all WINDOW.json, the manifest, with the size and the SHA-256 of each, of the history
/// and of the list of fields so far, and of itself, signed by the user's key: without it there is no cut. The last two
/// are kept.
class CheckpointFolder {
 public:
  explicit CheckpointFolder(std::string path) : path_(std::move(path)) {}

  static constexpr int kept = 2;
  /// The files that a run may write, in the form of OwnFiles::claim, below the folder of its results.
  [[nodiscard]] static std::vector<std::string> names(const std::vector<std::string>& participants);

  /// On the disk, with everything that was written to this file system before, when it returns; then older ones go.
  /// Throws MachineError or ConfigError and leaves nothing of it.
  void write(const Checkpoint& checkpoint) const;
  /// The last one all of whose files, with history and fields, are as they were written; nothing if there is none.
  /// `damaged`: what is wrong with those passed over.
  [[nodiscard]] std::optional<Checkpoint> last(std::vector<std::string>& damaged) const;
  /// Removes every trace of cuts after that window, and of those that have no manifest.
  void forget_after(std::int64_t window) const;
  /// Windows of the manifests, ascending.
  [[nodiscard]] std::vector<std::int64_t> windows() const;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  [[nodiscard]] std::string manifest(std::int64_t window) const;
  [[nodiscard]] std::string part(std::int64_t window, const std::string& participant) const;
  [[nodiscard]] Checkpoint read(std::int64_t window) const;
  void remove(std::int64_t window) const;

  std::string path_;
};

}  // namespace ricochet::coupler
