#include "coupler/report/shapes/shape_motion.hpp"

#include <algorithm>
#include <cmath>

namespace ricochet::report {
namespace {

double length_of(const Place& x) { return std::hypot(x[0], x[1], x[2]); }

Place beyond_flight(const Place& displacement, const Place& velocity_m_s, double flight_s) {
  Place beyond = displacement;
  for (std::size_t c = 0; c < 3; ++c) beyond[c] -= velocity_m_s[c] * flight_s;
  return beyond;
}

double extent_of(const Shapes& shapes) {
  Place low{}, high{};
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const auto& piece : shapes.pieces) {
    if (piece.rigid) continue;
    for (const auto& x : piece.position) {
      for (std::size_t c = 0; c < 3; ++c) {
        low[c] = std::min(low[c], x[c]);
        high[c] = std::max(high[c], x[c]);
      }
    }
  }
  return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
}

/// Fastest approach of two bodies in free flight, of one alone towards what stands still.
double fastest_approach(const Shapes& shapes) {
  double fastest = shapes.bodies.size() == 1 ? length_of(shapes.bodies[0].velocity_m_s) : 0.0;
  for (const auto& a : shapes.bodies) {
    for (const auto& b : shapes.bodies)
      fastest = std::max(fastest, length_of(beyond_flight(a.velocity_m_s, b.velocity_m_s, 1.0)));
  }
  return fastest;
}

}  // namespace

Place Magnification::place(const Place& position, const Place& displacement, const Place& velocity_m_s,
                           double time_s) const {
  const auto beyond = beyond_flight(displacement, velocity_m_s, std::min(time_s, flight_s));
  Place x{};
  for (std::size_t c = 0; c < 3; ++c) x[c] = position[c] + displacement[c] + (factor - 1.0) * beyond[c];
  return x;
}

Magnification magnification_of(const Shapes& shapes, const std::vector<std::size_t>& windows, double first_contact_s,
                               double first_gap_m) {
  constexpr double wanted_share = 0.15;
  Magnification result;
  const double extent = extent_of(shapes);
  if (!std::isfinite(first_contact_s)) {
    result.flight_s = std::numeric_limits<double>::infinity();
  } else if (first_gap_m > 1e-9 * extent) {
    // The history says in which window contact began, the gap and the speed say when.
    result.flight_s = first_gap_m / fastest_approach(shapes);
    const bool closed_by_flight = std::abs(result.flight_s - first_contact_s) <= 2.0 * shapes.largest_window_s;
    if (!closed_by_flight) return result;
  }
  if (shapes.nose || shapes.uneven) return result;
  double most = 0.0;
  for (const auto& piece : shapes.pieces) {
    const auto& velocity = shapes.bodies[static_cast<std::size_t>(piece.body)].velocity_m_s;
    if (piece.rigid) continue;
    for (const auto w : windows) {
      const double flight = std::min(shapes.times_s[w], result.flight_s);
      for (const auto& u : piece.displacement[w]) most = std::max(most, length_of(beyond_flight(u, velocity, flight)));
    }
  }
  const double ratio = most > 0.0 ? wanted_share * extent / most : 1.0;
  if (!(ratio > 1.0) || !std::isfinite(ratio)) return result;
  const double power = std::pow(10.0, std::floor(std::log10(ratio)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * power <= ratio) result.factor = step * power;
  }
  return result;
}

}  // namespace ricochet::report
