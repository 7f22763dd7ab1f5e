#include "common/contact/projection.hpp"

#include <algorithm>
#include <cmath>

#include "common/contact/friction.hpp"

namespace ricochet::solver {
namespace {

constexpr double inside_share = 1.0 - 1e-12;  ///< of the limit: a force longer than that is on the cone

/// Slip [m], with a penalty less what its spring gives.
Eigen::Vector2d slip_of(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                        const Eigen::Vector3d& moved) {
  return window.slip_free + moved.tail<2>() + pair.slack * (x.tail<2>() - window.last);
}

/// The motion that a pair's own tangential forces give it, the larger of two directions, with the slack [m/N].
double most_moved(const PairBlock& pair) { return pair.along.diagonal().maxCoeff() + pair.slack; }

/// tau - rho slip [N], 1/rho what the pair's own forces move it by.
Eigen::Vector2d reach(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                      const Eigen::Vector3d& moved) {
  Eigen::Vector2d reached = x.tail<2>() - slip_of(pair, window, x, moved) / most_moved(pair);
  for (int k = 0; k < 2; ++k)
    if (!pair.slides(k)) reached[k] = 0.0;
  return reached;
}

double limit_of(const PairBlock& pair, const Eigen::Vector3d& x) {
  return pair.friction_coefficient *
         std::max(0.0, x[0]);  // one that is about to open may pull by what round-off leaves
}

}  // namespace

bool PairRows::idle(int row) const {
  return rhs[row] == 0.0 && of_motion.row(row).isZero(0.0) && own.row(row) == Eigen::RowVector3d::Unit(row);
}

double Projection::normal(const PairBlock& pair, const PairWindow& window, double force, double moved) {
  if (!(pair.normal > 0.0)) return 0.0;
  return std::max(0.0, force - (window.gap_free + moved + pair.slack * force) / pair.normal);
}

Eigen::Vector2d Projection::tangential(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                                       const Eigen::Vector3d& moved) const {
  Eigen::Matrix2d moves = pair.along;
  Eigen::Vector2d free;
  if (regularised()) {
    moves *= 2.0 / dt_;
    free = 2.0 / dt_ * (window.slip_free + moved.tail<2>()) - window.slip_velocity - moves * x.tail<2>();
  } else {
    for (int k = 0; k < 2; ++k)
      if (pair.slides(k)) moves(k, k) += pair.slack;
    free = slip_of(pair, window, x, moved) - moves * x.tail<2>();
  }
  return friction_of_pair(law_, limit_of(pair, x), free, holding_of_pair(moves, free), moves);
}

/// gap = 0 and slip = 0, each divided by what its force moves alone, so that these rows and those of forces [N] are of
/// one size.
PairRows Projection::held_rows(const PairBlock& pair, const PairWindow& window) {
  PairRows rows;
  if (pair.normal > 0.0) {
    rows.own(0, 0) = pair.slack / pair.normal;
    rows.of_motion(0, 0) = 1.0 / pair.normal;
    rows.rhs[0] = -window.gap_free / pair.normal;
  }
  for (int k = 0; k < 2; ++k) {
    if (!pair.slides(k)) continue;
    const double alone = pair.along(k, k) + pair.slack;
    rows.own(1 + k, 1 + k) = pair.slack / alone;
    rows.of_motion(1 + k, 1 + k) = 1.0 / alone;
    rows.rhs[1 + k] = (pair.slack * window.last[k] - window.slip_free[k]) / alone;
  }
  return rows;
}

/// tau = mu lambda y/|y|, y = tau - rho slip, linearised about the present y: with e = y/|y| and c = mu lambda/|y| < 1
///   tau - mu e lambda - c (I - e e^T) (tau - rho slip) = 0
void Projection::slip_rows(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                           const Eigen::Vector2d& reached, PairRows& rows) const {
  const double length = reached.norm(), rho = 1.0 / most_moved(pair);
  const Eigen::Vector2d e = reached / length;
  const Eigen::Matrix2d across = limit_of(pair, x) / length * (Eigen::Matrix2d::Identity() - e * e.transpose());
  rows.own.bottomRows<2>() << -pair.friction_coefficient * e,
      Eigen::Matrix2d::Identity() - (1.0 - rho * pair.slack) * across;
  rows.of_motion.bottomRightCorner<2, 2>() = rho * across;
  rows.rhs.tail<2>() = -rho * across * (window.slip_free - pair.slack * window.last);
}

/// tau + mu lambda f(v) = 0, f(v) = tanh(xi |v|) v/|v|, linearised about the present v = 2 slip/dt - v_n; or about 0,
/// where f is steepest and Newton's method cannot overshoot, if the present tau turns the slip around.
void Projection::regularised_rows(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                                  const Eigen::Vector3d& moved, PairRows& rows) const {
  const double xi = law_.friction_regularisation_s_m;
  const Eigen::Vector2d slipped = moved.tail<2>();
  Eigen::Vector2d velocity = 2.0 / dt_ * (window.slip_free + slipped) - window.slip_velocity;
  for (int k = 0; k < 2; ++k)
    if (!pair.slides(k)) velocity[k] = 0.0;
  const Eigen::Vector2d without = velocity - 2.0 / dt_ * pair.along * x.tail<2>();
  const double speed = velocity.dot(without) < 0.0 ? 0.0 : velocity.norm();
  Eigen::Matrix2d slope = xi * Eigen::Matrix2d::Identity();  // df/dv
  Eigen::Vector2d value(0.0, 0.0), about(0.0, 0.0);
  if (speed > 0.0) {
    const Eigen::Vector2d e = velocity / speed;
    const double tanh = std::tanh(xi * speed);
    const Eigen::Matrix2d along_e = e * e.transpose();
    slope = tanh / speed * (Eigen::Matrix2d::Identity() - along_e) + xi * (1.0 - tanh * tanh) * along_e;
    value = tanh * e;
    about = velocity;
  }
  const Eigen::Matrix2d of_slip = 2.0 / dt_ * limit_of(pair, x) * slope;
  rows.own.bottomRows<2>() << pair.friction_coefficient * value, Eigen::Matrix2d::Identity();
  rows.of_motion.bottomRightCorner<2, 2>() = of_slip;
  rows.rhs.tail<2>() = of_slip * (slipped - 0.5 * dt_ * (velocity - about));
}

PairRows Projection::rows(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                          const Eigen::Vector3d& moved, ContactState& state) const {
  if (state == ContactState::open) return {};
  PairRows rows = held_rows(pair, window);
  if (!pair.slides()) return rows;
  if (regularised()) {
    regularised_rows(pair, window, x, moved, rows);
  } else if (state == ContactState::slip) {
    const Eigen::Vector2d reached = reach(pair, window, x, moved);
    if (reached.norm() <= limit_of(pair, x)) {
      state = ContactState::stick;
    } else {
      slip_rows(pair, window, x, reached, rows);
    }
  }
  for (int k = 1; k <= 2; ++k) {  // no force along a direction in which supports hold both sides
    if (pair.slides(k - 1)) continue;
    rows.own.row(k) = Eigen::RowVector3d::Unit(k);
    rows.of_motion.row(k).setZero();
    rows.rhs[k] = 0.0;
  }
  return rows;
}

ContactState Projection::next_state(const PairBlock& pair, const PairWindow& window, const Eigen::Vector3d& x,
                                    const Eigen::Vector3d& moved, ContactState state, double negligible_n,
                                    double negligible_m) const {
  if (state == ContactState::open) {
    // A pair that closes is first given mu times its force, against its slip: held, it may be torn open again.
    return window.gap_free + moved[0] < -negligible_m ? ContactState::slip : ContactState::open;
  }
  if (x[0] < -negligible_n) return ContactState::open;
  if (!pair.slides() || regularised()) return state;
  const double outside = reach(pair, window, x, moved).norm() - pair.friction_coefficient * x[0];
  if (std::abs(outside) <= negligible_n) return state;
  return outside > 0.0 ? ContactState::slip : ContactState::stick;
}

ContactState Projection::state_of(const PairBlock& pair, const Eigen::Vector3d& x) const {
  if (!(x[0] > 0.0)) return ContactState::open;
  const double limit = limit_of(pair, x) * inside_share;
  const bool inside = pair.slides() && !regularised() && x.tail<2>().norm() < limit;
  return inside ? ContactState::stick : ContactState::slip;
}

}  // namespace ricochet::solver
