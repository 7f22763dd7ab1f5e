#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/vocabulary.hpp"
#include "common/base/window_clock.hpp"
#include "coupler/results/departed.hpp"
#include "coupler/results/tally.hpp"

namespace ricochet::coupler {

/// One process of a run and where its time went [s].
struct ProcessTimes {
  std::string name;
  std::optional<Role> role;  ///< empty: the coupler
  std::int64_t process_id = 0;
  std::optional<Transport> transport;  ///< what carried its messages; empty: the coupler, or no hello came
  double wall_s = 0;
  std::optional<double> compute_s, wait_s;  ///< empty: it did not live to report them
  struct Waited {
    std::string whom;
    double time_s = 0;
  };
  std::vector<Waited> waited_for;
  bool inside = false;  ///< a participant in the coupler's process
};

struct Phases {
  double start_s = 0, setup_s = 0, stepping_s = 0, finish_s = 0;
};

struct SwitchEvent {
  double time_s = 0;
  Role to = Role::explicit_solver;  ///< how the implicit participant goes on

  void archive(Archive& a) { a(time_s, to); }
};

/// A body whose material has a limit; the other may be infinite [Pa].
struct BodyLimits {
  std::string body;
  double yield_stress_pa = 0.0, strength_pa = 0.0;
};

/// Everything that summary.json and the table at the end of a run say.
struct Summary {
  RunStatus status = RunStatus::running;
  std::string error;
  int exit_code = 0;
  std::string scene_path, scene_sha256, protocol, run_id;
  Transport transport = Transport::automatic;
  std::int64_t windows = 0;          ///< computed
  std::int64_t windows_planned = 0;  ///< up to the latest end
  WindowClock clock;
  double wall_s = 0;
  double cpu_s = 0;  ///< of the coupler and of the participants that it launched and saw end
  Phases phases;
  double largest_drift = 0;
  double added_mass_kg = 0, added_mass_share = 0;  ///< by mass scaling, and over what all bodies have by their density
  int substeps = 1;                                ///< explicit steps in a window of a dual protocol
  bool interface_known = false;                    ///< every participant tells the work of its link
  double interface_drift_m = 0;  ///< dual protocols: largest difference of the displacements of one shared node
  std::vector<BodyLimits> limits;
  std::vector<Departed> outside_model;
  std::optional<double> valid_until_s;  ///< what was written after it is wrong
  std::vector<SwitchEvent> switches;
  std::vector<std::string> energy_not_told_by, momentum_not_told_by;  ///< then those errors are none
  std::vector<std::string> notes;                                     ///< decisions of the run worth knowing
  std::vector<ProcessTimes> processes;
};

/// The text of summary.json.
[[nodiscard]] std::string to_json(const Summary& summary, const Tally& tally);
/// The line for the user on contact forces that were not found; empty if all were.
[[nodiscard]] std::string contact_warning(const Tally& tally);
/// The line for the user on windows that are too long for their substeps: dual protocols tie velocities at the end of a
/// window, and within it the two sides of the interface go apart, against the forces there. The energy that this makes
/// or loses is about the error of forces and rebound; from `largest_interface_energy` on it is said. Empty if less,
/// with one substep, and where not everybody tells.
inline constexpr double largest_interface_energy = 0.015;
[[nodiscard]] std::string substeps_warning(const Summary& summary, const Tally& tally);
/// The table at the end of a run.
[[nodiscard]] std::string to_table(const Summary& summary, const Tally& tally);

}  // namespace ricochet::coupler
