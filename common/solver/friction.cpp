#include "common/solver/friction.hpp"

#include <algorithm>
#include <cmath>

namespace ricochet::solver {

double friction_of_pair(const scene::Contact& law, double limit, double free_rate, double holding) {
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

}  // namespace ricochet::solver
