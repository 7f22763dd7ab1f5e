#pragma once

#include <chrono>
#include <cstdint>
#include <future>
#include <string>

#include "common/scene/scene.hpp"
#include "coupler/processes/launcher.hpp"
#include "coupler/results/checkpoint.hpp"
#include "coupler/results/field_digests.hpp"

namespace ricochet::coupler {

/// When a run saves all that it goes on from, and the writing, which goes on beside the run.
///
/// Due by windows, by wall time, by SIGUSR1, by SIGTERM (then the run ends), or by a file `request` in the folder,
/// which `ricochet checkpoint` puts there. While one is being written none begins by time or by windows. A checkpoint
/// that cannot be written is told of on stderr, and the run goes on: the one before is still there.
class Checkpoints {
 public:
  /// `fields`: of the same folder of results, up to where the run begins. `launcher` must outlive it.
  Checkpoints(const scene::Checkpointing& settings, std::string folder, FieldDigests fields, Launcher& launcher);
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;
  /// Waits for what is being written.
  ~Checkpoints();

  static constexpr const char* request_name = "request";

  enum class Due { no, yes, last };
  /// After a window is accepted; `last`: the run is to end with it.
  [[nodiscard]] Due due(std::int64_t window);
  /// Writes it, with the digests of the fields up to its window, after the one before.
  void begin(Checkpoint checkpoint);
  /// Waits until the last one that was begun is written or has failed. Returns its window; < 0: there is none.
  std::int64_t settle();

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] bool requested(Clock::time_point now);
  [[nodiscard]] bool writing() const;

  scene::Checkpointing settings_;
  CheckpointFolder folder_;
  FieldDigests fields_;  ///< of the thread that writes
  Launcher& launcher_;
  Clock::time_point begun_ = Clock::now(), looked_ = begun_;
  std::future<std::string> written_;  ///< what went wrong
  std::int64_t window_ = -1, last_whole_ = -1;
  bool answers_request_ = false;
};

}  // namespace ricochet::coupler
