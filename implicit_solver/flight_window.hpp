#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/window_clock.hpp"
#include "implicit_solver/combined_parts.hpp"
#include "implicit_solver/contact/implicit_contact.hpp"

namespace ricochet::implicit_solver {

/// One window of central difference (common/body/central_difference.hpp) on all the implicit participant integrates,
/// with the same lumped masses and no contact force: the flight after separation.
class FlightWindow {
 public:
  /// `contact` (null: none) and `parts` must outlive this object.
  FlightWindow(const CombinedParts& parts, ImplicitContact* contact, const WindowClock& clock);

  /// `trial.end.link` holds the link's force.
  void advance(std::int64_t window, const WindowState& state, WindowTrial& trial);
  /// Massless contact nodes begin in balance with the others: their displacement from that of the others.
  void settle_at_start(const Eigen::VectorXd& external);

 private:
  void settle(const Eigen::VectorXd& external);

  const CombinedParts& parts_;
  ImplicitContact* contact_;
  const WindowClock& clock_;
  std::vector<Eigen::VectorXd> moved_, internal_;  ///< per part: u and P(u) at the end of the window
  std::vector<Eigen::VectorXd> part_external_;     ///< per part: f for the balance of massless nodes
};

}  // namespace ricochet::implicit_solver
