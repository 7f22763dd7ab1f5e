// The part of RootProblem for solids: friction with two tangential directions on the circular cone.
#include <algorithm>
#include <cmath>

#include "common/solver/friction.hpp"
#include "common/solver/root_problem.hpp"

namespace ricochet::solver {

Eigen::Vector2d RootProblem::along(int pair, const Eigen::VectorXd& x) const {
  return {x[pairs_ + pair], x[2 * pairs_ + pair]};
}

double RootProblem::set_along(int pair, const Eigen::Vector2d& tangential) {
  const double change = (tangential - along(pair, solution_.force)).cwiseAbs().maxCoeff();
  solution_.force[pairs_ + pair] = tangential[0];
  solution_.force[2 * pairs_ + pair] = tangential[1];
  return change;
}

/// Whether a row of the present states depends on the forces.
bool RootProblem::turns() const {
  if (!friction_ || regularised_) return friction_;
  return cone_ &&
         std::any_of(states_.begin(), states_.end(), [](const PairState& s) { return s.tangent == Tangent::slip; });
}

/// Slip [m] by `motion_` = D x, with a penalty less what its spring gives.
Eigen::Vector2d RootProblem::slip_of(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const {
  const Eigen::Vector2d slip = Eigen::Vector2d(slip_free[pair], slip_free[pairs_ + pair]) + along(pair, motion_);
  return slip + slack(pair) * (along(pair, solution_.force) - along(pair, last.force));
}

/// tau - rho slip [N], 1/rho what the pair's own forces move it by: inside the cone's disc the pair sticks, outside it
/// slips along it.
Eigen::Vector2d RootProblem::reach(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const {
  const double moves = block_[static_cast<std::size_t>(pair)].diagonal().maxCoeff() + slack(pair);
  Eigen::Vector2d reached = along(pair, solution_.force) - slip_of(pair, slip_free, last) / moves;
  for (int k = 0; k < 2; ++k) {
    if (compliance_.alone((1 + k) * pairs_ + pair) <= 0.0) reached[k] = 0.0;
  }
  return reached;
}

/// slip = 0, each row divided by what its unknown moves alone.
RootProblem::ConeRows RootProblem::stick_rows(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const {
  ConeRows rows{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  for (int k = 0; k < 2; ++k) {
    const int t = (1 + k) * pairs_ + pair;
    rows.of_slip(k, k) = 1.0 / alone(t);
    rows.own(k, k) = slack(pair) / alone(t);
    rows.rhs[k] = (slack(pair) * last.force[t] - slip_free[k * pairs_ + pair]) / alone(t);
  }
  return rows;
}

/// tau = mu lambda y/|y|, y = tau - rho slip, linearised about the present y: with e = y/|y| and c = mu lambda/|y| < 1
///   tau - mu e lambda - c (I - e e^T) (tau - rho slip) = 0
RootProblem::ConeRows RootProblem::slip_rows(int pair, const Eigen::VectorXd& slip_free, const Solution& last) const {
  const double mu = friction_of(pair);
  const double rho = 1.0 / (block_[static_cast<std::size_t>(pair)].diagonal().maxCoeff() + slack(pair));
  const Eigen::Vector2d y = reach(pair, slip_free, last);
  const double length = y.norm();
  const Eigen::Vector2d e = y / length;
  const double share = mu * std::max(0.0, solution_.force[pair]) / length;
  const Eigen::Matrix2d across = share * (Eigen::Matrix2d::Identity() - e * e.transpose());
  const Eigen::Vector2d free =
      Eigen::Vector2d(slip_free[pair], slip_free[pairs_ + pair]) - slack(pair) * along(pair, last.force);
  return {Eigen::Matrix2d::Identity() - (1.0 - rho * slack(pair)) * across, rho * across, -mu * e,
          -rho * across * free};
}

/// tau + mu lambda f(v) = 0, f(v) = tanh(xi |v|) v/|v|, linearised about the present v; or about 0, where f is steepest
/// and Newton's method cannot overshoot, if the present tau turns the slip around.
RootProblem::ConeRows RootProblem::regularised_rows(int pair, const Eigen::VectorXd& slip_free,
                                                    const Eigen::VectorXd& slip_velocity) const {
  const double xi = law_.friction_regularisation_s_m, mu = friction_of(pair);
  const Eigen::Vector2d slipped = along(pair, motion_);
  const Eigen::Vector2d velocity = 2.0 / dt_ * (Eigen::Vector2d(slip_free[pair], slip_free[pairs_ + pair]) + slipped) -
                                   Eigen::Vector2d(slip_velocity[pair], slip_velocity[pairs_ + pair]);
  const Eigen::Vector2d without =
      velocity - 2.0 / dt_ * block_[static_cast<std::size_t>(pair)] * along(pair, solution_.force);
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
  const Eigen::Matrix2d of_slip = 2.0 / dt_ * mu * std::max(0.0, solution_.force[pair]) * slope;
  return {Eigen::Matrix2d::Identity(), of_slip, mu * value, of_slip * (slipped - 0.5 * dt_ * (velocity - about))};
}

/// Rows of the present states at the present forces, with `motion_` = D x where rows turn. A pair that slipped and now
/// could hold is made to stick.
void RootProblem::find_cone_rows(const Eigen::VectorXd& slip_free, const Eigen::VectorXd& slip_velocity,
                                 const Solution& last) {
  for (int i = 0; i < pairs_; ++i) {
    auto& tangent = states_[static_cast<std::size_t>(i)].tangent;
    auto& rows = cone_rows_[static_cast<std::size_t>(i)];
    const double limit = friction_of(i) * std::max(0.0, solution_.force[i]);
    if (tangent == Tangent::slip && reach(i, slip_free, last).norm() <= limit) tangent = Tangent::stick;
    switch (tangent) {
      case Tangent::stick: rows = stick_rows(i, slip_free, last); break;
      case Tangent::slip: rows = slip_rows(i, slip_free, last); break;
      case Tangent::regularised: rows = regularised_rows(i, slip_free, slip_velocity); break;
      default:
        rows = {Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    }
    for (int k = 0; k < 2; ++k) {  // no force along a direction in which supports hold both sides
      if (compliance_.alone((1 + k) * pairs_ + i) > 0.0) continue;
      rows.own.row(k) = Eigen::RowVector2d::Unit(k);
      rows.of_slip.row(k).setZero();
      rows.of_normal[k] = rows.rhs[k] = 0.0;
    }
  }
}

void RootProblem::cone_right_hand_side() {
  for (int i = 0; i < pairs_; ++i) {
    const auto& rows = cone_rows_[static_cast<std::size_t>(i)];
    rhs_[pairs_ + i] = rows.rhs[0];
    rhs_[2 * pairs_ + i] = rows.rhs[1];
  }
}

void RootProblem::assemble_cone(int pair) {
  const auto& rows = cone_rows_[static_cast<std::size_t>(pair)];
  const int unknown[] = {pairs_ + pair, 2 * pairs_ + pair};
  for (int k = 0; k < 2; ++k) {
    const int row = place(unknown[k]);
    for (int l = 0; l < 2; ++l) {
      add_compliance(row, rows.of_slip(k, l), unknown[l]);
      matrix_(row, place(unknown[l])) += rows.own(k, l);
    }
    matrix_(row, place(pair)) += rows.of_normal[k];
  }
}

/// Of y = D x the rows of a pair, as `assemble_cone` has them.
void RootProblem::times_cone(int pair, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  const auto& rows = cone_rows_[static_cast<std::size_t>(pair)];
  const Eigen::Vector2d of = rows.own * along(pair, x) + rows.of_slip * along(pair, y) + rows.of_normal * x[pair];
  y[pairs_ + pair] = of[0];
  y[2 * pairs_ + pair] = of[1];
}

/// Tangential forces of a pair if its normal force and the forces of all others were right; `motion_` holds its rows of
/// D x.
Eigen::Vector2d RootProblem::cone_alone(int pair, const Eigen::VectorXd& slip_free,
                                        const Eigen::VectorXd& slip_velocity, const Solution& last) const {
  const Eigen::Vector2d force = along(pair, solution_.force);
  const double limit = friction_of(pair) * std::max(0.0, solution_.force[pair]);
  Eigen::Matrix2d moves = block_[static_cast<std::size_t>(pair)];
  Eigen::Vector2d free;
  if (regularised_) {
    moves *= 2.0 / dt_;
    free = 2.0 / dt_ * (Eigen::Vector2d(slip_free[pair], slip_free[pairs_ + pair]) + along(pair, motion_)) -
           Eigen::Vector2d(slip_velocity[pair], slip_velocity[pairs_ + pair]) - moves * force;
  } else {
    for (int k = 0; k < 2; ++k)
      if (moves(k, k) > 0.0) moves(k, k) += slack(pair);
    free = slip_of(pair, slip_free, last) - moves * force;
  }
  return friction_of_pair(law_, limit, free, holding_of_pair(moves, free), moves);
}

}  // namespace ricochet::solver
