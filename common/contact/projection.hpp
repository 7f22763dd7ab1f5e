#pragma once

#include <Eigen/Core>

#include "common/contact/contact_record.hpp"
#include "common/scene/scene.hpp"

namespace ricochet::solver {

/// One pair: the motion that its own forces give it, and the numbers of its law.
struct PairBlock {
  double friction_coefficient = 0.0;
  double slack = 0.0;   ///< 1/(alpha w) of a penalty, 0 of a multiplier [m/N]
  double normal = 0.0;  ///< what its normal force moves its gap by, with the slack [m/N]
  /// Motion by its tangential forces [m/N]; zero without friction, and along what supports hold on both sides: it
  /// has no tangential forces there. In two dimensions the binormal is such a direction.
  Eigen::Matrix2d along = Eigen::Matrix2d::Zero();

  [[nodiscard]] bool slides(int direction) const { return along(direction, direction) > 0.0; }
  [[nodiscard]] bool slides() const { return slides(0) || slides(1); }
};

/// One pair in one window: gap and slip at its end without contact forces, relative velocity along the surface at
/// its begin, tangential force of the window before.
struct PairWindow {
  double gap_free = 0.0;
  Eigen::Vector2d slip_free{0.0, 0.0}, slip_velocity{0.0, 0.0}, last{0.0, 0.0};
};

/// One linear equation for each force of a pair: own x + of_motion D x = rhs, without units or in N.
struct PairRows {
  Eigen::Matrix3d own = Eigen::Matrix3d::Identity(), of_motion = Eigen::Matrix3d::Zero();
  Eigen::Vector3d rhs{0.0, 0.0, 0.0};

  bool operator==(const PairRows&) const = default;
  /// Whether a row says that its force is zero.
  [[nodiscard]] bool idle(int row) const;
};

/// The conditions of one pair (RootProblem) as projections, and their derivatives. x = (lambda, tau) are the
/// forces of a pair, `moved` = D x along normal, tangent and binormal.
///   lambda = max(0, lambda - rho gap)
///   tau = P(tau - rho slip), P the projection to the disc of radius mu lambda: inside it the pair sticks
class Projection {
 public:
  Projection(const scene::Contact& law, double dt) : law_(law), dt_(dt) {}

  /// The force of a pair if all others were right, and along the surface its normal one, too.
  [[nodiscard]] static double normal(const PairBlock& pair, const PairWindow& window, double force, double moved);
  [[nodiscard]] Eigen::Vector2d tangential(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                                           const Eigen::Vector3d& moved) const;

  /// The derivative of the projection at x in a state. One that slipped and now could hold is made to stick.
  [[nodiscard]] PairRows rows(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                              const Eigen::Vector3d& moved, ContactState& state) const;
  /// Closed and sticking, whatever the sign of the force.
  [[nodiscard]] static PairRows held_rows(const PairBlock& pair, const PairWindow& window);
  /// The state that the criteria ask for after a pair had the rows of `state`; `negligible`: force and gap that are
  /// round-off.
  [[nodiscard]] ContactState next_state(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                                        const Eigen::Vector3d& moved, ContactState state, double negligible_n,
                                        double negligible_m) const;
  [[nodiscard]] ContactState state_of(const PairBlock& pair, const Eigen::Vector3d& x) const;
  /// Whether the rows of a state change with x and `moved`.
  [[nodiscard]] bool turns(ContactState state) const { return state == ContactState::slip || regularised(); }

 private:
  [[nodiscard]] bool regularised() const { return law_.friction_law == scene::FrictionLaw::regularised; }
  void slip_rows(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                 const Eigen::Vector2d& reached, PairRows& rows) const;
  void regularised_rows(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                        const Eigen::Vector3d& moved, PairRows& rows) const;

  scene::Contact law_;
  double dt_;
};

}  // namespace ricochet::solver
