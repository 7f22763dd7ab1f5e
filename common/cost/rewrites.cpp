#include "common/cost/rewrites.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/check/check_reach.hpp"

namespace ricochet::cost {
namespace {

using fem::at;

constexpr double share = 0.01, of_gap = 0.25;  // of an edge, of the distance: SlidingRows

/// How often rows are written anew while bodies are apart by up to `gap_m`, of which they close or open `normal_m_s`
/// and slide `along_m_s`: for each `share` of an edge, and from four times that on for each quarter of the gap.
double rewrites_in_flight(double gap_m, double edge_m, double normal_m_s, double along_m_s) {
  if (!(normal_m_s > 0.0)) return 0.0;
  const double speed_m_s = std::hypot(normal_m_s, along_m_s);
  const double near_m = share * edge_m / of_gap * speed_m_s / along_m_s;
  const double near = std::min(gap_m, near_m) / normal_m_s * along_m_s / (share * edge_m);
  if (gap_m <= near_m) return near;
  return near + std::log(std::min(gap_m, edge_m) / near_m) / std::log1p(of_gap * normal_m_s / speed_m_s);
}

}  // namespace

std::vector<double> rewrites(const scene::Problem& problem, double end_s, const std::vector<double>& contact_s) {
  std::vector<double> counts(problem.contacts.size(), 0.0);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto& contact = problem.contacts[i];
    if (!contact.sliding) continue;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), gravity = velocity;
    for (const auto& [body, sign] : {std::pair{contact.body_b, 1.0}, std::pair{contact.body_a, -1.0}}) {
      const auto& spec = problem.scene.bodies[at(body)];
      for (std::size_t c = 0; c < spec.initial_velocity_m_s.size(); ++c)
        velocity[static_cast<Eigen::Index>(c)] += sign * spec.initial_velocity_m_s[c];
      for (std::size_t c = 0; c < spec.gravity_m_s2.size(); ++c)
        gravity[static_cast<Eigen::Index>(c)] += sign * spec.gravity_m_s2[c];
    }
    const Eigen::Vector3d& normal = contact.touch_normal;
    const auto along = [&](const Eigen::Vector3d& x) { return (x - x.dot(normal) * normal).norm(); };
    const double edge_m = contact.sliding->edge_m, closing_m_s = -velocity.dot(normal), along_m_s = along(velocity);
    const double first_s = std::min(end_s, scene::first_contact_s(problem, contact));
    const double touching_s = std::min(end_s - first_s, i < contact_s.size() ? contact_s[i] : end_s);
    counts[i] = (along_m_s * touching_s + 0.5 * along(gravity) * touching_s * touching_s) / (share * edge_m);
    if (!(along_m_s > 0.0)) continue;
    for (const double flight_s : {first_s, end_s - first_s - touching_s})
      counts[i] += rewrites_in_flight(closing_m_s * flight_s, edge_m, closing_m_s, along_m_s);
  }
  return counts;
}

}  // namespace ricochet::cost
