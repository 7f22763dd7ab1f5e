#pragma once

#include <Eigen/Core>

#include "common/scene/scene.hpp"

namespace ricochet::solver {

/// The friction that one pair has, as a force [N] or as an impulse [N s], alone of all its forces unknown.
///   return mapping:  t = holding, clipped to |t| <= limit                                   (Eq. 9, 14, 21-24)
///   regularised:     t = -limit tanh(xi v), v = free_rate (1 - t / holding)                 (Eq. 14, 15)
/// `limit` = mu times the normal force or impulse, >= 0; `free_rate`: relative tangential velocity [m/s] that the pair
/// would have without t; `holding`: the t that would make it zero.
[[nodiscard]] double friction_of_pair(const scene::Contact& law, double limit, double free_rate, double holding);

/// The same along tangent and binormal at once, with the circular cone of Coulomb's law, for a pair that moves by
/// v = free_rate + W t, W = `inverse` symmetric, zero along a direction in which supports hold the pair (in two
/// dimensions: the second), and holding = -W^-1 free_rate:
///   return mapping:  v = 0 if |holding| <= limit, else |t| = limit and v = -eta t, eta >= 0
///   regularised:     t = -limit tanh(xi |v|) v/|v|
/// If its masses let a pair move alike in all directions, the first is the radial return, t = holding
/// limit/|holding|; else eta solves |(W + eta I)^-1 free_rate| = limit (the trust-region subproblem of More and
/// Sorensen, 1983).
[[nodiscard]] Eigen::Vector2d friction_of_pair(const scene::Contact& law, double limit,
                                               const Eigen::Vector2d& free_rate, const Eigen::Vector2d& holding,
                                               const Eigen::Matrix2d& inverse);

/// -W^-1 rate: what stops a pair, of the components along which it can be moved.
[[nodiscard]] Eigen::Vector2d holding_of_pair(const Eigen::Matrix2d& inverse, const Eigen::Vector2d& rate);

/// t, or where it is longer than `limit` the vector of that length along it.
[[nodiscard]] Eigen::Vector2d clip_to_cone(const Eigen::Vector2d& t, double limit);

}  // namespace ricochet::solver
