#include "coupler/watch/overlap_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

/// A share of the thinner body: by no more of it may the two move against each other from one step to the next.
constexpr double step_share = 0.25;
constexpr double most_steps = 1e5;
/// A share of the way since the last look: so well is the instant of an overlap found.
constexpr double resolved_share = 1e-3;

Eigen::Vector3d mean(const std::vector<Eigen::Vector3d>& values) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

OverlapWatch::OverlapWatch(const scene::Problem& problem) : problem_(problem) {
  const auto apart = scene::pairs_without_contact(problem);
  const auto contacts = scene::contacts_to_watch(problem);
  if (apart.empty() && contacts.empty()) return;
  for (const auto& body : problem.bodies) {
    Body watched{body.name, scene::Shape(body), {}, {}, {}};
    const std::size_t nodes = watched.shape.outline().nodes.size();
    const int components = problem.scene.components();
    watched.told.assign(nodes, false);
    for (const int node : watched.shape.outline().nodes) {
      Eigen::Vector3d u = Eigen::Vector3d::Zero();
      for (int c = 0; c < components; ++c) u[c] = body.initial_displacement_m[node * components + c];
      watched.before.push_back(u);
    }
    watched.now = watched.before;
    bodies_.push_back(std::move(watched));
  }
  const auto shape = [&](int body) -> const scene::Shape& { return bodies_[fem::at(body)].shape; };
  for (const auto& pair : apart)
    pairs_.push_back({pair.first, pair.second, scene::overlap_tolerance(shape(pair.first), shape(pair.second)),
                      Eigen::Vector3d::Zero(), false});
  for (const scene::ContactGeometry* contact : contacts) {
    const int a = contact->body_a, b = contact->body_b >= 0 ? contact->body_b : a;
    const double tolerance_m = scene::overlap_tolerance(shape(a), shape(b), problem.scene.contact_law(), *contact);
    if (b != a) {
      const auto same = std::find_if(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
        return std::minmax({pair.first, pair.second}) == std::minmax({a, b});
      });
      if (same == pairs_.end()) {
        pairs_.push_back({a, b, tolerance_m, contact->lifted_m, true});
      } else {  // facets of one contact lie beside the other
        same->tolerance_m = std::max(same->tolerance_m, tolerance_m);
      }
      continue;
    }
    const scene::Contact& spec = problem.scene.contacts[static_cast<std::size_t>(contact - problem.contacts.data())];
    const char* const name = scene::obstacle_names[static_cast<std::size_t>(spec.obstacle)];
    rigid_.push_back({a, name, scene::RigidShape(spec, *contact, problem.bodies[fem::at(a)].mesh), tolerance_m});
  }
}

bool OverlapWatch::Body::all_told() const {
  return std::all_of(told.begin(), told.end(), [](bool node) { return node; });
}

void OverlapWatch::Body::archive(Archive& a) {
  const auto nodes = now.size();
  a(told, before, now);
  if (told.size() != nodes || before.size() != nodes || now.size() != nodes) a.refuse("another outline");
}

void OverlapWatch::archive(Archive& a) {
  for (auto& body : bodies_) a(body);
  a(last_window_);
}

void OverlapWatch::take(const Link& link) {
  const auto& told = link.outline();
  const auto& names = link.description().bodies;
  std::vector<std::vector<Body>::iterator> bodies;
  for (const auto& name : names)
    bodies.push_back(std::find_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return b.name == name; }));
  for (int row = 0; row < told.rows; ++row) {
    const double* values = &told.data[static_cast<std::size_t>(row * told.columns)];
    const auto body = bodies[static_cast<std::size_t>(values[0])];
    const auto& nodes = body->shape.outline().nodes;
    const auto node = std::lower_bound(nodes.begin(), nodes.end(), values[1]);
    if (node == nodes.end() || *node != values[1]) {
      throw ProtocolError(
          fmt::format("participant '{}' named node {} of body '{}' in 'outline', which is not on its outline",
                      link.name(), values[1], body->name));
    }
    const auto at = static_cast<std::size_t>(node - nodes.begin());
    body->told[at] = true;
    for (int c = 0; c + 2 < told.columns; ++c) body->now[at][c] = values[2 + c];
  }
}

void OverlapWatch::move(Body& body, double share, const Eigen::Vector3d& lifted_m) {
  std::vector<Eigen::Vector3d> displacement(body.now.size());
  for (std::size_t i = 0; i < displacement.size(); ++i)
    displacement[i] = body.before[i] + share * (body.now[i] - body.before[i]) + lifted_m;
  body.shape.move(displacement);
}

int OverlapWatch::steps(const Body& a, const Body& b) const {
  const Eigen::Vector3d moved = mean(a.now) - mean(a.before) - mean(b.now) + mean(b.before);
  const double thin_m = std::min(a.shape.thickness(), b.shape.thickness());
  return 1 + static_cast<int>(std::min(most_steps, moved.norm() / (step_share * thin_m)));
}

scene::Shape::Overlap OverlapWatch::overlap_at(const Pair& pair, double share) {
  Body &a = bodies_[fem::at(pair.first)], &b = bodies_[fem::at(pair.second)];
  move(a, share);
  move(b, share, pair.lifted_m);
  return a.shape.overlap(b.shape, pair.tolerance_m);
}

/// Share of the way since the last look; above 1 if they are apart all the way.
double OverlapWatch::first_overlap(const Pair& pair) {
  const auto overlapped = [&](double share) { return overlap_at(pair, share).depth_m > pair.tolerance_m; };
  const int count = steps(bodies_[fem::at(pair.first)], bodies_[fem::at(pair.second)]);
  for (int step = 1; step <= count; ++step) {
    double apart = static_cast<double>(step - 1) / count, share = static_cast<double>(step) / count;
    if (!overlapped(share)) continue;
    while (share - apart > resolved_share) (overlapped(0.5 * (apart + share)) ? share : apart) = 0.5 * (apart + share);
    return share;
  }
  return 2.0;
}

double OverlapWatch::time_s(std::int64_t window, double share) const {
  const double begin_s = problem_.clock.time_s(last_window_);
  return begin_s + share * (problem_.clock.time_s(window) - begin_s);
}

void OverlapWatch::look_at(const Pair& pair, std::int64_t window, std::vector<Found>& found) {
  const Body &a = bodies_[fem::at(pair.first)], &b = bodies_[fem::at(pair.second)];
  if (!a.all_told() || !b.all_told()) return;
  const double share = first_overlap(pair);
  if (share > 1.0) return;
  const auto overlap = overlap_at(pair, share);
  found.push_back({a.name, b.name, pair.beside_contact, overlap.depth_m, time_s(window, share), time_s(window, 0.0),
                   overlap.place});
}

/// Nothing flies through what its surface must touch before, so the end of the way is enough. When it came there is
/// known to one look.
void OverlapWatch::look_at(const Rigid& rigid, std::int64_t window, std::vector<Found>& found) {
  Body& body = bodies_[fem::at(rigid.body)];
  if (!body.all_told()) return;
  move(body, 1.0);
  const Eigen::Vector3d& deepest = body.shape.deepest(rigid.shape);
  const double depth_m = rigid.shape.depth_m(deepest);
  if (!(depth_m > rigid.tolerance_m)) return;
  found.push_back({body.name, rigid.name, true, depth_m, time_s(window, 1.0), time_s(window, 0.0), deepest});
}

std::vector<OverlapWatch::Found> OverlapWatch::update(const std::vector<Link>& links, std::int64_t window) {
  std::vector<Found> found;
  if (bodies_.empty()) return found;
  for (const auto& link : links) take(link);
  for (const auto& pair : pairs_) look_at(pair, window, found);
  for (const auto& rigid : rigid_) look_at(rigid, window, found);
  for (auto& body : bodies_) body.before = body.now;
  last_window_ = window;
  return found;
}

}  // namespace ricochet::coupler
