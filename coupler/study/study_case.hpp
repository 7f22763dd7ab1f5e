#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/check/check.hpp"
#include "common/scene/variant.hpp"
#include "coupler/study/study_measures.hpp"

namespace ricochet::coupler {

/// The time that one repeat of a run took [s]; set-up is meshes and factorisation, start the processes.
struct Cost {
  double wall_s = 0.0, cpu_s = 0.0, start_s = 0.0, setup_s = 0.0, stepping_s = 0.0;
};

/// Folder name of a run: digest of all that its numbers depend on, the scene (with its meshes), the programs and this
/// version.
[[nodiscard]] std::string run_key(const std::string& scene_sha256, const std::vector<std::string>& program_sha256);

/// One variant of a scene, in <folder>/<key>: scene.toml, and a results folder for each repeat, "1", "2", ... Repeats
/// that are there already count; one that was interrupted, or whose participant failed, is computed again.
class StudyCase {
 public:
  /// Writes the variant, without output of fields and axial stresses (what is measured is the computation), and checks
  /// it; one that is refused has the status `scene_wrong`.
  StudyCase(const std::string& scene_path, std::vector<scene::Override> changes, const std::string& folder);

  /// Computes one more repeat, or takes one that is there by now. The reason of an early end becomes the status, but
  /// Interrupted goes through.
  void compute();
  [[nodiscard]] bool failed() const { return !error_.empty(); }
  [[nodiscard]] int repeats() const { return static_cast<int>(costs_.size()); }
  [[nodiscard]] const std::vector<Cost>& costs() const { return costs_; }
  [[nodiscard]] std::optional<RunStatus> status() const { return status_; }  ///< empty: not computed yet
  [[nodiscard]] std::string status_text() const { return status_ ? std::string(name_of(*status_)) : "waiting"; }
  [[nodiscard]] const std::string& error() const { return error_; }  ///< first line
  [[nodiscard]] int exit_code() const { return exit_code_; }
  [[nodiscard]] const std::string& folder() const { return folder_; }
  [[nodiscard]] std::string key() const;  ///< name of the folder
  [[nodiscard]] const scene::Problem& problem() const { return *problem_; }
  [[nodiscard]] long long steps() const { return steps_; }
  [[nodiscard]] double step_s() const { return plan_ ? problem_->clock.size_s(1) : 0.0; }
  /// The observation of the first repeat.
  [[nodiscard]] Observation observation() const;

 private:
  [[nodiscard]] std::string repeat_folder(int repeat) const { return folder_ + "/" + std::to_string(repeat); }
  bool read_repeat(int repeat);
  void fail(RunStatus status, int exit_code, const std::string& error);

  std::string folder_, error_;
  std::optional<RunStatus> status_;
  int exit_code_ = 0;
  std::optional<scene::Problem> problem_;
  std::optional<scene::Plan> plan_;
  std::vector<std::string> executables_;
  std::vector<Cost> costs_;
  long long steps_ = 0;
};

}  // namespace ricochet::coupler
