#pragma once

#include <string>

namespace ricochet::coupler {

/// The command line of `ricochet stability`.
struct StabilityRequest {
  std::string scene, out;                     ///< `out` empty: "out/<name of the scene file>_stability"
  std::string sweep = "courant=0.5:1.05:12";  ///< the steps, see parse_step_axis
  std::string against;                        ///< the other parameter, see parse_axis; empty: the scene as it is
  bool edge = false;                          ///< bisect the measured edges
};

/// `ricochet stability`: prints critical time steps and, for every point of the sweep, the growth per window of the
/// coupled scheme, measured by the scene's own participants; writes stability.csv, stability.html and the scene file of
/// every point (variants/). Throws what `run_scene` throws.
void study_stability(const StabilityRequest& request);

}  // namespace ricochet::coupler
