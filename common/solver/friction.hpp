#pragma once

#include "common/scene/scene.hpp"

namespace ricochet::solver {

/// What friction gives one pair, as a force [N] or as an impulse [N s], alone of all its forces unknown.
///   return mapping:  t = holding, clipped to |t| <= limit                                   (Eq. 9, 14, 21-24)
///   regularised:     t = -limit tanh(xi v), v = free_rate (1 - t / holding)                 (Eq. 14, 15)
/// `limit` = mu times the normal force or impulse, >= 0; `free_rate`: relative tangential velocity [m/s] that the pair
/// would have without t; `holding`: the t that would make it zero.
[[nodiscard]] double friction_of_pair(const scene::Contact& law, double limit, double free_rate, double holding);

}  // namespace ricochet::solver
