#pragma once

#include <string>
#include <vector>

#include "common/check/check.hpp"
#include "common/problem/problem.hpp"

/// The cost that a run would have on this machine, before it is started.
namespace ricochet::cost {

struct MachineSpeed {
  /// How much longer a small K u takes here than on the machine whose figures `predict_cost` has.
  double slowness = 1.0;
  int processors = 2;
};
/// Some milliseconds.
[[nodiscard]] MachineSpeed measure_speed();

struct PredictedCost {
  struct Process {
    std::string name;
    double window_s = 0.0;  ///< mean of what it computes in a window
  };
  std::vector<Process> participants;
  double windows = 0.0;
  double window_s = 0.0;      ///< mean time from window to window
  double factor_bytes = 0.0;  ///< of the implicit participant and of modes, at the start
  double field_bytes = 0.0;   ///< of one time of fields, all participants' files together
  double field_files = 0.0;   ///< that many they are
  double setup_s = 0.0;       ///< of the participant that takes longest, before the first window
  double all_implicit_s = 0.0, all_explicit_s = 0.0;  ///< stepping of the baselines to the same end
  double all_explicit_step_s = 0.0;                   ///< the scene's, or what all elements together allow
  double local_explicit_s = 0.0;  ///< the same in the scene's steps, the small ones of fine elements inside them

  [[nodiscard]] double stepping_s() const { return windows * window_s; }
};

/// Counts of what a window does, from the scene, times what each takes. K u is measured on a sample of the scene's own
/// elements; the rest are figures of the machine of docs/speed.md times `speed.slowness`. Bodies that may yield do so
/// in every window. `end_s`: of the run [s]. `contact_s`: per contact how long the bodies touch; without it until the
/// end. Throws std::bad_alloc.
[[nodiscard]] PredictedCost predict_cost(const scene::Problem& problem, const scene::Plan& plan, double end_s,
                                         const MachineSpeed& speed, const std::vector<double>& contact_s = {});

}  // namespace ricochet::cost
