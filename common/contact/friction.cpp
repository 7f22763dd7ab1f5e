#include "common/contact/friction.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace ricochet::solver {
namespace {

/// Eigenvalues of W below this share of the larger one are round-off: supports hold the pair in that direction.
constexpr double held_share = 1e-12;
constexpr double tolerance = 1e-14;
constexpr double alike_share = 1e-14;
constexpr int most_steps = 100;

/// W in its principal directions, and what the pair would do along them without friction.
struct Principal {
  Eigen::Matrix2d directions;
  Eigen::Array2d inverse, free_rate;

  Principal(const Eigen::Matrix2d& w, const Eigen::Vector2d& rate) {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
    solver.computeDirect(w);
    directions = solver.eigenvectors();
    inverse = solver.eigenvalues();
    free_rate = directions.transpose() * rate;
    for (int k = 0; k < 2; ++k) {
      if (inverse[k] <= held_share * inverse[1]) inverse[k] = free_rate[k] = 0.0;
    }
  }
};

/// |(W + eta I)^-1 free_rate| = limit. In 1/|t| - 1/limit, which is nearly linear and concave, Newton's method from
/// eta = 0 stays on one side.
Eigen::Vector2d slip_on_cone(const Eigen::Matrix2d& w, const Eigen::Vector2d& rate, double limit) {
  const Principal of(w, rate);
  const auto force = [&](double eta) -> Eigen::Array2d {
    Eigen::Array2d t(0.0, 0.0);
    for (int k = 0; k < 2; ++k)
      if (of.inverse[k] > 0.0) t[k] = -of.free_rate[k] / (of.inverse[k] + eta);
    return t;
  };
  double eta = 0.0;
  Eigen::Array2d t = force(eta);
  for (int i = 0; i < most_steps; ++i) {
    const double length = t.matrix().norm();
    if (length - limit <= tolerance * limit) break;
    double slope = 0.0;  // d|t|/d eta, negative
    for (int k = 0; k < 2; ++k)
      if (of.inverse[k] > 0.0) slope -= t[k] * t[k] / (length * (of.inverse[k] + eta));
    eta += length * (length - limit) / (-slope * limit);
    t = force(eta);
  }
  return clip_to_cone(of.directions * t.matrix(), limit);
}

/// t = -kappa v, v = (I + kappa W)^-1 free_rate and kappa |v| = limit tanh(xi |v|), whose sides grow and fall with
/// kappa: Newton's method between bounds.
Eigen::Vector2d regularised_on_cone(const Eigen::Matrix2d& w, const Eigen::Vector2d& rate, double limit, double xi) {
  const Principal of(w, rate);
  if (limit <= 0.0 || of.free_rate.isZero(0.0)) return Eigen::Vector2d::Zero();
  double low = 0.0, high = limit * xi, kappa = high;
  Eigen::Array2d v(0.0, 0.0);
  for (int i = 0; i < most_steps; ++i) {
    v = of.free_rate / (1.0 + kappa * of.inverse);
    const double speed = v.matrix().norm(), tanh = std::tanh(xi * speed);
    const double slope = -(of.inverse * v.square() / (1.0 + kappa * of.inverse)).sum() / speed;
    const double excess = kappa * speed - limit * tanh;
    (excess > 0.0 ? high : low) = kappa;
    double next = kappa - excess / (speed + kappa * slope - limit * xi * (1.0 - tanh * tanh) * slope);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double change = next - kappa;
    if (std::abs(change) <= tolerance * kappa) break;
    kappa = next;
  }
  return of.directions * (-kappa * v).matrix();
}

}  // namespace

double friction_of_pair(const scene::Contact& law, double limit, double free_rate, double holding) {
  if (limit < 0.0) return 0.0;  // a pair that pulls, which only a damaged state has
  if (law.friction_law == scene::FrictionLaw::return_mapping) return std::clamp(holding, -limit, limit);
  if (free_rate == 0.0 || holding == 0.0) return 0.0;
  // Taken at `free_rate` itself, the law would count what one window of it stops. Newton's method for v + d tanh(xi v)
  // = free_rate from rest stays on one side, where the law is steepest first.
  const double xi = law.friction_regularisation_s_m, stops = limit * std::abs(free_rate / holding);
  double v = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double tanh = std::tanh(xi * v);
    const double change = (free_rate - v - stops * tanh) / (1.0 + stops * xi * (1.0 - tanh * tanh));
    v += change;
    if (std::abs(change) <= 1e-14 * std::abs(free_rate)) break;
  }
  return -limit * std::tanh(xi * v);
}

Eigen::Vector2d friction_of_pair(const scene::Contact& law, double limit, const Eigen::Vector2d& free_rate,
                                 const Eigen::Vector2d& holding, const Eigen::Matrix2d& inverse) {
  if (limit < 0.0) return Eigen::Vector2d::Zero();
  if (inverse(0, 0) <= 0.0 || inverse(1, 1) <= 0.0) {  // one direction, as in two dimensions
    const int free = inverse(1, 1) > 0.0 ? 1 : 0;
    Eigen::Vector2d t(0.0, 0.0);
    t[free] = friction_of_pair(law, limit, free_rate[free], holding[free]);
    return t;
  }
  if (law.friction_law == scene::FrictionLaw::regularised)
    return regularised_on_cone(inverse, free_rate, limit, law.friction_regularisation_s_m);
  const bool alike = std::abs(inverse(0, 0) - inverse(1, 1)) <= alike_share * inverse.trace() && inverse(0, 1) == 0.0;
  if (alike || limit <= 0.0 || holding.squaredNorm() <= limit * limit) return clip_to_cone(holding, limit);
  return slip_on_cone(inverse, free_rate, limit);
}

Eigen::Vector2d holding_of_pair(const Eigen::Matrix2d& inverse, const Eigen::Vector2d& rate) {
  if (inverse(0, 1) == 0.0) {
    return {inverse(0, 0) > 0.0 ? -rate[0] / inverse(0, 0) : 0.0, inverse(1, 1) > 0.0 ? -rate[1] / inverse(1, 1) : 0.0};
  }
  const Principal of(inverse, rate);
  Eigen::Vector2d holding(0.0, 0.0);
  for (int k = 0; k < 2; ++k)
    if (of.inverse[k] > 0.0) holding -= of.free_rate[k] / of.inverse[k] * of.directions.col(k);
  return holding;
}

Eigen::Vector2d clip_to_cone(const Eigen::Vector2d& t, double limit) {
  const double length = std::hypot(t[0], t[1]);
  if (length <= limit) return t;
  return limit * (t / length);
}

}  // namespace ricochet::solver
