#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "coupler/interface/peer.hpp"
#include "coupler/results/history.hpp"
#include "coupler/watch/untold.hpp"

namespace ricochet::coupler {

/// Follows the name of a protocol that loses momentum.
inline constexpr const char* does_not_keep_momentum = "does not keep it; \"hughes_liu\" does";

/// A reason, known before the run, why it might blow up.
struct Suspicion {
  std::string protocol;
  std::string protocol_trouble;     ///< empty: none known
  double step_s = 0.0;              ///< the longest of the explicit participants
  std::string step_key{};           ///< of the scene, which sets it
  double penalty_step_ratio = 0.0;  ///< sqrt(2 alpha_n/m) dt, 0 without penalty
  struct Step {
    std::string participant;
    double critical_time_step_s = 0.0;  ///< of an explicit participant; <= 0: not stated
  };
  std::vector<Step> steps;
  std::vector<std::string> foreign;  ///< participants that are programs of somebody else's
  std::string scene_path;
  bool links_told = true;      ///< everyone tells the work of its link, by which it is known who makes energy
  bool keeps_momentum = true;  ///< the protocol does, to rounding
};

/// How much of a balance may be lost before a run is stopped; infinite: as much as there is.
struct LossLimits {
  double energy = std::numeric_limits<double>::infinity();    ///< of EnergyBalance::reference_j
  double momentum = std::numeric_limits<double>::infinity();  ///< HistoryRow::momentum_error
};

/// "participant 'x', a program of your own: ...", and how to find out more.
[[nodiscard]] std::string check_advice(const std::string& participant, const std::string& scene_path);

/// "likely cause: ..." for a run that became unstable. `interface_j`: energy the coupling made so far.
[[nodiscard]] std::string likely_cause(const Suspicion& suspicion, double interface_j, double growth_j);

/// A run that the energy watch has stopped; its text ends with the likely cause.
struct EnergyGrowth : SolverError {
  using SolverError::SolverError;
};

/// Stops a run whose numbers mean nothing any more.
///
/// It looks every so many windows, whatever rows the history file keeps, so that `output.history_every` changes no
/// verdict. Where most of the energy comes from outside (loads, prescribed motion), growth counts only once it has
/// lasted: a jump of a prescribed velocity is resolved by the step to half a window's work, which is much of the work
/// done so far at first and little later. A loss counts in the same way.
class EnergyWatch {
 public:
  static constexpr std::int64_t every = 8;  ///< windows from look to look
  /// The same of a run of so many windows: a short one is looked at after each.
  [[nodiscard]] static std::int64_t every_of(double windows) { return windows < 1000.0 ? 1 : every; }
  static constexpr std::int64_t patience =
      32;  ///< windows that growth must last where most of the energy comes from outside

  /// `limit`: largest growth of the energy balance, relative to its reference or, if that is more, `floor_j`; infinite
  /// where not everybody tells of its energy.
  /// `participants`, `bodies`: names for the texts.
  EnergyWatch(double limit, double floor_j, Suspicion suspicion, std::vector<std::string> participants,
              std::vector<std::string> bodies, std::int64_t look_every = every, LossLimits losses = {});

  /// Throws EnergyGrowth naming window, time, where energy was made and the likely cause, if the energy balance has
  /// grown by more than the limit, more energy or momentum was lost than may be, or anything in the row is not finite.
  void check(const HistoryRow& row);
  /// Largest share of the momentum so far that came from nowhere or got lost; 0 where it is not told.
  [[nodiscard]] double momentum_lost() const { return momentum_lost_; }
  void archive(Archive& a) {
    a(balance_, last_energy_j_, growing_since_, losing_since_, drifting_since_, momentum_lost_);
  }

 private:
  [[noreturn]] void stop(const HistoryRow& row, const std::string& what, double growth_j) const;
  [[nodiscard]] std::string culprit(const HistoryRow& row, double growth_j) const;
  /// `beyond` its limit now, and for as long as it takes to count. `since`: the first window of that.
  [[nodiscard]] bool counts(bool beyond, std::int64_t window, std::optional<std::int64_t>& since) const;
  void check_losses(const HistoryRow& row, double lost_j, double reference_j);

  LossLimits losses_;
  double limit_, floor_j_;
  std::int64_t every_;
  Suspicion suspicion_;
  std::vector<std::string> participants_, bodies_;
  EnergyBalance balance_;
  double momentum_lost_ = 0.0;
  std::vector<double> last_energy_j_;                                          ///< per body
  std::optional<std::int64_t> growing_since_, losing_since_, drifting_since_;  ///< window
};

/// The shares that may be lost in a run of these participants: nothing is limited that not everybody tells of.
[[nodiscard]] LossLimits loss_limits(const scene::Problem& problem, const Untold& untold);

/// Energy below which round-off decides: that of strains of 1e-12, 1e-24 m c^2 of all bodies [J].
[[nodiscard]] double energy_floor_j(const scene::Problem& problem);

}  // namespace ricochet::coupler
