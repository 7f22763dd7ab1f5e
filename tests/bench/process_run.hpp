#pragma once

#include <string>
#include <vector>

namespace ricochet::bench {

/// Usage by a finished command and the processes it waited for; all but the first as the kernel counted it.
struct Usage {
  double wall_s = 0.0;
  double cpu_s = 0.0;              ///< user and system, all processes
  double largest_process_b = 0.0;  ///< largest resident set of any one of them [bytes]
};

/// Runs a command to its end, its output in the file `log`. Throws ParticipantError with the log if it fails.
Usage run_command(std::vector<std::string> command, const std::string& log);

/// Largest sum of the resident sets of `ricochet run` and of all processes it starts, looked at every 10 ms [bytes].
/// (Each shared page counts once a process.) Throws as run_command.
double peak_memory_of_run_b(const std::string& scene, const std::string& out);

/// The results and the cost of `ricochet run`.
struct SceneRun {
  double window_s = 0.0;                  ///< stepping time per window
  double step_s = 0.0;                    ///< stepping time per step of the explicit side
  double setup_s = 0.0;                   ///< start of the processes and set-up of the coupling
  double stepping_s = 0.0, wall_s = 0.0;  ///< of all windows; of the whole run
  double peak_force_n = 0.0;              ///< largest contact force of the history
  double speed_change_m_s =
      0.0;  ///< of the steel body, from its first row to its last: the contact's impulse over mass
  Usage usage;
};

/// `substeps`: explicit steps in a window.
SceneRun run_scene(const std::string& scene, int substeps, const std::string& out);

}  // namespace ricochet::bench
