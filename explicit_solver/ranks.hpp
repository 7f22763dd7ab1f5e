#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/fem/local_steps.hpp"
#include "common/participant/participant.hpp"
#include "explicit_solver/stepping.hpp"

namespace ricochet::explicit_solver {

/// Orders that all ranks of a participant obey together. The first one tells the others, which do nothing on their own.
enum class Order {
  synchronise,
  reconfigure,
  advance,
  advance_substep,
  accept,
  work_ahead,
  sums,
  motion,
  save,
  restore,
  end
};

/// The ranks of a participant as the first of them sees them: it alone talks to the coupler, has the shared and the
/// contact nodes, and reports.
class Ranks {
 public:
  virtual ~Ranks() = default;
  /// Shares out the nodes of the whole parts, gives every rank its share of them and lets the others get ready. Returns
  /// the first one's share, and takes what only stepping needs out of `whole`.
  virtual std::vector<solver::BodyState>& begin(const scene::Problem& problem,
                                                const scene::ParticipantSpec& participant,
                                                const participant::Setup& setup,
                                                std::vector<solver::BodyState>& whole) = 0;
  /// The small steps of a part of the first one's share, which has all nodes that they reach.
  virtual fem::LocalSteps local_steps(std::size_t part) = 0;
  /// The others do what `order` says, of a window where it is of one, while the first one does the same.
  virtual void tell(Order order, std::int64_t window = 0, int substep = 0) = 0;
  /// Between windows: this is the clock from here on.
  virtual void reconfigure(WindowClock clock) = 0;
  /// Ask all ranks: the totals of the last accepted window, and its motion, of all nodes into `whole`.
  virtual void take_totals(const Stepping& own, double dt, std::vector<solver::BodyState>& whole) = 0;
  virtual void take_motion(std::vector<solver::BodyState>& whole) = 0;
  /// The states that each of the others has to remember, and that put back.
  virtual std::vector<std::string> save() = 0;
  virtual void restore(const std::vector<std::string>& saved) = 0;
};

}  // namespace ricochet::explicit_solver
