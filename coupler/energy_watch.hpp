#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/check.hpp"
#include "coupler/history.hpp"

namespace ricochet::coupler {

/// What is known before the run about why it might blow up.
struct Suspicion {
  std::string protocol;
  std::string protocol_trouble;  ///< empty: none known
  double step_s = 0.0;  ///< of the explicit participants
  double penalty_step_ratio = 0.0;  ///< sqrt(2 alpha_n/m) dt, 0 without penalty
  struct Step {
    std::string participant;
    double critical_time_step_s = 0.0;  ///< of an explicit participant; <= 0: not stated
  };
  std::vector<Step> steps;
};

/// "likely cause: ..." for a run that became unstable. `interface_j`: energy the coupling made so far.
[[nodiscard]] std::string likely_cause(const Suspicion& suspicion, double interface_j, double growth_j);

/// Stops a run whose numbers mean nothing any more.
class EnergyWatch {
 public:
  /// `limit`: largest relative growth of the energy balance. `participants`, `bodies`: names for the texts.
  EnergyWatch(double limit, Suspicion suspicion, std::vector<std::string> participants,
              std::vector<std::string> bodies);

  /// Throws SolverError naming window, time, where energy was made and the likely cause, if the energy balance has
  /// grown by more than the limit or anything in the row is not finite.
  void check(const HistoryRow& row, const Errors& errors);

 private:
  [[noreturn]] void stop(const HistoryRow& row, const std::string& what, double growth_j) const;
  [[nodiscard]] std::string culprit(const HistoryRow& row, double growth_j) const;

  double limit_;
  Suspicion suspicion_;
  std::vector<std::string> participants_, bodies_;
  std::vector<double> last_energy_j_;  ///< per body
  std::int64_t rows_ = 0;
};

}  // namespace ricochet::coupler
