#include "common/check/check_reach.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/fem/element.hpp"
#include "common/fem/interval.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

using fem::Interval;

double axis_of(const BodyProblem& body, int node) {
  return fem::axis_coordinate(body.section.model, body.mesh.position[at(node)]);
}

/// The length that an element takes up along the axis.
Interval extent_of(const BodyProblem& body, const fem::Element& element) {
  Interval extent;
  for (const int node : element) extent.add(axis_of(body, node));
  return extent;
}

bool any(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double x) { return x != 0.0; });
}

/// At t = 0 every part of the body is at rest in itself, and nothing acts on all of it.
bool starts_at_rest(const Body& spec, Model model) {
  const bool widens = model == Model::axisymmetric &&
                      (spec.initial_velocity_m_s[0] != 0.0 || spec.initial_displacement_start_m[0] != 0.0);
  return !any(spec.gravity_m_s2) && spec.initial_displacement_start_m == spec.initial_displacement_end_m && !widens;
}

/// Where something but the contact makes waves from t = 0 on: loads, prescribed motion, supports that stop the body,
/// and what a foreign body, of which nothing is known, may send.
Interval disturbed(const Body& spec, const BodyProblem& body) {
  Interval interval;
  const auto add_surface = [&](const std::string& surface) {
    for (const int node : fem::surface_nodes(body.mesh, surface)) interval.add(axis_of(body, node));
  };
  for (const Traction& traction : spec.tractions)
    if (traction.pressure_pa != 0.0 || any(traction.traction_pa)) add_surface(traction.surface);
  for (const PrescribedMotion& prescribed : spec.prescribed) add_surface(prescribed.surface);
  for (const Support& support : spec.supports)
    for (const int c : support.components)
      if (spec.initial_velocity_m_s[at(c)] != 0.0 || spec.initial_displacement_start_m[at(c)] != 0.0)
        add_surface(support.surface);
  for (int node = 0; node < static_cast<int>(body.joined_node.size()); ++node)
    if (body.joined_node[at(node)]) interval.add(axis_of(body, node));
  return interval;
}

/// A front that went d along elements of the length h is some (d h²)^(1/3) wide, so its foot is before it. Twice that
/// leaves 1e-5 of a contact force, `UnreachedEnds.CanBeLeftOut`.
double foot_m(const Problem& problem, const BodyProblem& body, double speed_m_s, double way_m) {
  double longest_m = speed_m_s * problem.clock.largest_size_s();  // of implicit ones, whatever their elements
  for (const auto& element : body.mesh.elements) {
    const Interval extent = extent_of(body, element);
    longest_m = std::max(longest_m, extent.high - extent.low);
  }
  return 2.0 * std::cbrt(way_m * longest_m * longest_m);
}

/// The part of a body that its contact hears of. Without other waves than those of the contact these have to come back.
struct Reached {
  Interval interval;
  bool comes_back = false;
};

Reached reached(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  const double speed = fastest_wave_m_s(body), end_s = problem.scene.time.end_s;
  Interval interval = disturbed(problem.scene.bodies[at(index)], body);
  const bool comes_back = interval.empty();
  if (!interval.empty()) interval = {interval.low - speed * end_s, interval.high + speed * end_s};
  const std::vector<int> contact = contact_nodes(problem.contacts, index);
  const double way = speed * (end_s - first_contact_s(problem));
  const double to_the_end = comes_back && way > 0.0 ? 0.5 * way + foot_m(problem, body, speed, way) : way;
  const double reach = contact.empty() ? -1.0 : std::min(way, to_the_end);
  for (const int node : reach >= 0.0 ? contact : std::vector<int>{}) {
    interval.add(axis_of(body, node) - reach);
    interval.add(axis_of(body, node) + reach);
  }
  return {interval, comes_back};
}

/// The elements of a body that lie below (above) a place on the axis, as a line; empty if there are none.
std::string beyond(const BodyProblem& body, const Reached& reached, bool above, double end_s) {
  const double place = above ? reached.interval.high : reached.interval.low;
  Interval whole, unreached;
  int elements = 0;
  for (const auto& element : body.mesh.elements) {
    const Interval extent = extent_of(body, element);
    whole.add(extent.low);
    whole.add(extent.high);
    if (above ? extent.low < place : extent.high > place) continue;
    unreached.add(above ? extent.low : extent.high);
    ++elements;
  }
  if (elements == 0) return "";
  const double length = above ? whole.high - unreached.low : unreached.high - whole.low;
  return fmt::format(
      "no wave {} the {:.4g} m at the {} end of \"{}\" ({} of {} elements) before {:.4g} s: the contact would not "
      "notice if they were left out",
      reached.comes_back ? "comes back from" : "reaches", length, above ? "high" : "low", body.name, elements,
      body.mesh.elements.size(), end_s);
}

}  // namespace

double first_contact_s(const Problem& problem, const ContactGeometry& contact) {
  double closing = 0.0, gap = std::numeric_limits<double>::infinity();
  for (const auto& [index, sign] : {std::pair{contact.body_a, 1.0}, std::pair{contact.body_b, -1.0}}) {
    if (index < 0) continue;
    const Body& spec = problem.scene.bodies[at(index)];
    if (!starts_at_rest(spec, problem.scene.model) || any(spec.initial_displacement_start_m) ||
        !disturbed(spec, problem.bodies[at(index)]).empty())
      return 0.0;
    for (std::size_t c = 0; c < spec.initial_velocity_m_s.size(); ++c)
      closing += sign * contact.normal[static_cast<Eigen::Index>(c)] * spec.initial_velocity_m_s[c];
  }
  for (const ContactPair& pair : contact.pairs) gap = std::min(gap, pair.gap0_m);
  if (gap == 0.0) return 0.0;
  return closing > 0.0 ? gap / closing : std::numeric_limits<double>::infinity();
}

double first_contact_s(const Problem& problem) {
  double first_s = std::numeric_limits<double>::infinity();
  for (const ContactGeometry& contact : problem.contacts)
    first_s = std::min(first_s, first_contact_s(problem, contact));
  return first_s;
}

std::vector<std::string> unreached_ends(const Problem& problem) {
  std::vector<std::string> lines;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const BodyProblem& body = problem.bodies[at(index)];
    if (!starts_at_rest(problem.scene.bodies[at(index)], problem.scene.model)) continue;
    const Reached known = reached(problem, index);
    if (known.interval.empty()) continue;
    for (const bool above : {false, true}) {
      const std::string line = beyond(body, known, above, problem.scene.time.end_s);
      if (!line.empty()) lines.push_back(line);
    }
  }
  return lines;
}

}  // namespace ricochet::scene
