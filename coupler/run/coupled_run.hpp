#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/check/check.hpp"
#include "coupler/processes/first_windows.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/results/axial_stress.hpp"
#include "coupler/results/history_file.hpp"
#include "coupler/results/probes.hpp"
#include "coupler/results/results_directory.hpp"
#include "coupler/results/summary.hpp"
#include "coupler/results/trace.hpp"
#include "coupler/run/checkpoints.hpp"
#include "coupler/run/programs.hpp"
#include "coupler/run/progress.hpp"
#include "coupler/run/time_loop.hpp"
#include "coupler/watch/energy_watch.hpp"
#include "coupler/watch/outside_model.hpp"
#include "coupler/watch/scene_comparison.hpp"

namespace ricochet::coupler {

/// One run of a scene from the first process to the last file. The phases, in order: start the participants, set the
/// coupling up, step, finish. Stateless about mechanics.
class CoupledRun {
 public:
  /// The arguments must outlive the run. `from`: where an earlier run of the scene is to go on; null: at the start.
  CoupledRun(scene::Problem& problem, const scene::Plan& plan, const std::vector<std::string>& executables,
             const ResultsDirectory& results, const Checkpoint* from = nullptr);

  /// To the end. Throws what ended it early; then call `fail`.
  void run();
  /// Ends all participants and writes what there is.
  void fail(RunStatus status, int exit_code, const std::string& error);
  [[nodiscard]] std::string table() const { return to_table(summary_, tally_); }

 private:
  using Clock = std::chrono::steady_clock;

  /// Processor time of this process and of its children that have ended [s].
  [[nodiscard]] static double cpu_time_s();

  // Spent so far, by the runs before of which this one is the rest, too.
  [[nodiscard]] double wall_s() const;
  [[nodiscard]] double cpu_spent_s() const;
  [[nodiscard]] double stepping_s() const;
  void phases();
  void start();
  void setup();
  void compare_with_scene(std::vector<PeerDescription>& descriptions);
  void try_links();
  void prepare_first_windows();
  void compare_first_windows();
  void prepare_watch(const std::vector<PeerDescription>& descriptions, const Untold& untold);
  /// Says it now, and in the summary.
  void warn(const std::string& text);
  void note_untold(const Untold& untold);
  void note_lost_momentum();
  [[nodiscard]] bool may_switch();
  void prepare_checkpoints(const std::vector<PeerDescription>& descriptions);
  void restore();
  void archive(Archive& a);
  void step();
  void save_if_due(std::int64_t window);
  void save(std::int64_t window);
  void take_records(std::int64_t window);
  void prepare_probes(const std::vector<PeerDescription>& descriptions);
  void note_untold_probes(const std::vector<PeerDescription>& descriptions);
  void write_probes(std::optional<double> valid_until_s);
  void take_contact_forces(const std::vector<double>& rows, std::optional<double> valid_until_s);
  void add_forces(const HistoryRow& row);
  void count_contact(const HistoryRow& row);
  void note_departures(std::int64_t window);
  void finish();
  void take_times(const std::vector<wire::Finished>& last_words);
  void write_files();
  void write_fields_and_trace();
  void write_summary();
  void reserve_summary() const;

  scene::Problem& problem_;  ///< whose clock is that of the windows so far
  const scene::Scene& scene_;
  const scene::Plan& plan_;
  const std::vector<std::string>& executables_;
  const ResultsDirectory& results_;
  const Checkpoint* from_;
  const Clock::time_point begin_ = Clock::now();
  const double begin_cpu_s_ = cpu_time_s();
  Clock::time_point stepping_ = begin_;
  Summary summary_;
  Tally tally_;
  HistoryFile history_file_;
  Progress progress_;
  Suspicion suspicion_;
  std::vector<TraceTrack> tracks_;
  std::vector<ContactCounter> contact_counters_;
  ProcessSet set_;
  std::unique_ptr<Protocol> protocol_;
  std::unique_ptr<Coupling> coupling_;
  std::unique_ptr<History> history_;
  std::unique_ptr<AxialStress> axial_stress_;  ///< null if the scene does not ask
  std::unique_ptr<Probes> probes_;             ///< the same
  std::unique_ptr<RowFile> probe_file_;        ///< the same
  std::unique_ptr<EnergyWatch> watch_;
  std::vector<std::optional<SceneComparison>> comparisons_;   ///< per participant, until its first row has come
  std::vector<std::unique_ptr<FirstWindows>> first_windows_;  ///< of foreign participants, as far as they are looked at
  OutsideModel outside_;
  ContactRecord since_last_row_;  ///< iterations and residual of rows that the watch alone has looked at
  bool forces_told_ = false;      ///< by the contact's owner, of every window
  std::unique_ptr<TimeLoop> loop_;
  std::optional<Checkpoints> checkpoints_;  ///< of participants that can all save their state
  std::vector<Program> programs_;           ///< of the same
};

}  // namespace ricochet::coupler
