#include "common/check/check_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/check/check_reach.hpp"
#include "common/problem/build.hpp"
#include "common/problem/outline.hpp"

namespace ricochet::scene {
namespace {

/// Instants at which shapes are compared while their boxes overlap.
constexpr int samples = 200;

std::vector<Eigen::Vector3d> initial_displacement(const Problem& problem, const BodyProblem& body,
                                                  const Outline& outline) {
  const int components = problem.scene.components();
  std::vector<Eigen::Vector3d> displacement;
  for (const int node : outline.nodes) {
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    for (int c = 0; c < components; ++c) u[c] = body.initial_displacement_m[node * components + c];
    displacement.push_back(u);
  }
  return displacement;
}

Eigen::Vector3d velocity(const Body& body) {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < body.initial_velocity_m_s.size(); ++c)
    v[static_cast<Eigen::Index>(c)] = body.initial_velocity_m_s[c];
  return v;
}

struct TimeSpan {
  double begin_s = 0.0, end_s = 0.0;
};

/// When the box of `a`, moving with this velocity against that of `b`, overlaps it.
TimeSpan boxes_overlap(const Shape& a, const Shape& b, const Eigen::Vector3d& v, TimeSpan time) {
  for (int axis = 0; axis < 3; ++axis) {
    const double gap_low = b.low()[axis] - a.high()[axis], gap_high = b.high()[axis] - a.low()[axis];
    if (!a.counts(axis) || !b.counts(axis)) continue;
    if (v[axis] == 0.0) {
      if (gap_low >= 0.0 || gap_high <= 0.0) return {1.0, 0.0};
      continue;
    }
    const double one = gap_low / v[axis], other = gap_high / v[axis];
    time = {std::max(time.begin_s, std::min(one, other)), std::min(time.end_s, std::max(one, other))};
  }
  return time;
}

/// Time of the first overlap on a straight flight [s]; infinity without one.
double meeting_time(Shape a, const Shape& b, const std::vector<Eigen::Vector3d>& start, const Eigen::Vector3d& v,
                    double until_s) {
  const TimeSpan time = boxes_overlap(a, b, v, {0.0, until_s});
  for (int i = 1; time.end_s > time.begin_s && i <= samples; ++i) {
    const double t = time.begin_s + (time.end_s - time.begin_s) * i / samples;
    std::vector<Eigen::Vector3d> moved = start;
    for (auto& u : moved) u += t * v;
    a.move(moved);
    if (a.overlap(b).depth_m > overlap_tolerance(a, b)) return t;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

void check_overlaps(const Problem& problem, Plan& plan) {
  const double first_touch_s = first_contact_s(problem);
  for (const BodyPair& pair : pairs_without_contact(problem)) {
    const BodyProblem &a = problem.bodies[at(pair.first)], &b = problem.bodies[at(pair.second)];
    Shape shape_a(a), shape_b(b);
    const auto start = initial_displacement(problem, a, shape_a.outline());
    shape_a.move(start);
    shape_b.move(initial_displacement(problem, b, shape_b.outline()));
    const Shape::Overlap overlap = shape_a.overlap(shape_b);
    if (overlap.depth_m > overlap_tolerance(shape_a, shape_b))
      throw ConfigError(
          fmt::format("{}: found a body that overlaps body \"{}\" by {:.3g} m at {}, "
                      "with no contact between "
                      "them; allowed: bodies that are apart",
                      problem.scene.where("body." + b.name + ".mesh"), a.name, overlap.depth_m,
                      fem::place_text(problem.scene.model, overlap.place)));
    double until_s = problem.scene.time.end_s;
    for (const ContactGeometry& contact : problem.contacts)
      for (const int body : {pair.first, pair.second})
        if (body == contact.body_a || body == contact.body_b) until_s = std::min(until_s, first_touch_s);
    const Eigen::Vector3d v =
        velocity(problem.scene.bodies[at(pair.first)]) - velocity(problem.scene.bodies[at(pair.second)]);
    const double meeting_s = meeting_time(shape_a, shape_b, start, v, until_s);
    if (std::isfinite(meeting_s))
      plan.warnings.push_back(
          fmt::format("bodies \"{}\" and \"{}\" meet at about {:.4g} s if they fly straight on, "
                      "and no contact is declared "
                      "between them: the run stops there",
                      a.name, b.name, meeting_s));
  }
}

namespace {

void check_slip_in_flight(const Problem& problem, const ContactGeometry& contact, Plan& plan) {
  const bool slides = contact.body_b >= 0 && problem.scene.components() == 2 && !contact.sliding;
  const double touch_s = slides ? first_contact_s(problem, contact) : 0.0;
  if (!std::isfinite(touch_s) || touch_s == 0.0) return;
  const Eigen::Vector3d tangent = tangent_of(contact.normal);
  const Eigen::Vector3d v =
      velocity(problem.scene.bodies[at(contact.body_a)]) - velocity(problem.scene.bodies[at(contact.body_b)]);
  std::vector<double> places;
  for (const ContactPair& pair : contact.pairs)
    places.push_back(tangent.dot(problem.bodies[at(contact.body_a)].mesh.position[at(pair.node_a)]));
  std::sort(places.begin(), places.end());
  double edge_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < places.size(); ++i) edge_m = std::min(edge_m, places[i] - places[i - 1]);
  const double slip_m = std::abs(v.dot(tangent)) * touch_s;
  if (!(slip_m > 0.5 * edge_m)) return;
  const bool ended = problem.bodies[at(contact.body_a)].mesh.period_m == 0.0;
  plan.warnings.push_back(fmt::format(
      "when the bodies touch, at {:.4g} s, they have moved {:.3g} m along the contact surface, {:.3g} element "
      "edges{}",
      touch_s, slip_m, slip_m / edge_m,
      ended && slip_m > edge_m ? ": nodes are past the end of their partner's surface, and the run "
                                 "stops there"
                               : ": pressure and friction act that far from their place"));
}

}  // namespace

void check_slip_in_flight(const Problem& problem, Plan& plan) {
  for (const ContactGeometry& contact : problem.contacts) check_slip_in_flight(problem, contact, plan);
}

}  // namespace ricochet::scene
