#include "coupler/watch/overlap_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

/// Of the thinner body: by no more of it may the two move against each other from one step to the next.
constexpr double step_share = 0.25;
constexpr double most_steps = 1e5;
/// Of the way since the last look: so well is the instant of an overlap found.
constexpr double resolved_share = 1e-3;

Eigen::Vector3d mean(const std::vector<Eigen::Vector3d>& values) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

OverlapWatch::OverlapWatch(const scene::Problem& problem)
    : problem_(problem), pairs_(scene::pairs_without_contact(problem)) {
  if (pairs_.empty()) return;
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
  for (int row = 0; row < told.rows; ++row) {
    const double* values = &told.data[static_cast<std::size_t>(row * told.columns)];
    const auto& name = link.description().bodies[static_cast<std::size_t>(values[0])];
    const auto body = std::find_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return b.name == name; });
    const auto& nodes = body->shape.outline().nodes;
    const auto node = std::find(nodes.begin(), nodes.end(), values[1]);
    if (node == nodes.end()) {
      throw ProtocolError(
          fmt::format("participant '{}' named node {} of body '{}' in 'outline', which is not on its outline",
                      link.name(), values[1], name));
    }
    const auto at = static_cast<std::size_t>(node - nodes.begin());
    body->told[at] = true;
    for (int c = 0; c + 2 < told.columns; ++c) body->now[at][c] = values[2 + c];
  }
}

void OverlapWatch::move(Body& body, double share) {
  std::vector<Eigen::Vector3d> displacement(body.now.size());
  for (std::size_t i = 0; i < displacement.size(); ++i)
    displacement[i] = body.before[i] + share * (body.now[i] - body.before[i]);
  body.shape.move(displacement);
}

int OverlapWatch::steps(const Body& a, const Body& b) const {
  const Eigen::Vector3d moved = mean(a.now) - mean(a.before) - mean(b.now) + mean(b.before);
  const double thin_m = std::min(a.shape.thickness(), b.shape.thickness());
  return 1 + static_cast<int>(std::min(most_steps, moved.norm() / (step_share * thin_m)));
}

scene::Shape::Overlap OverlapWatch::overlap_at(Body& a, Body& b, double share) {
  move(a, share);
  move(b, share);
  return a.shape.overlap(b.shape);
}

/// Share of the way since the last look; above 1 if they are apart all the way.
double OverlapWatch::first_overlap(Body& a, Body& b) const {
  const auto overlapped = [&](double share) {
    return overlap_at(a, b, share).depth_m > scene::overlap_tolerance(a.shape, b.shape);
  };
  const int count = steps(a, b);
  for (int step = 1; step <= count; ++step) {
    double apart = static_cast<double>(step - 1) / count, share = static_cast<double>(step) / count;
    if (!overlapped(share)) continue;
    while (share - apart > resolved_share) (overlapped(0.5 * (apart + share)) ? share : apart) = 0.5 * (apart + share);
    return share;
  }
  return 2.0;
}

std::vector<OverlapWatch::Found> OverlapWatch::update(const std::vector<Link>& links, std::int64_t window) {
  std::vector<Found> found;
  if (pairs_.empty()) return found;
  for (const auto& link : links) take(link);
  const auto all_told = [](const Body& body) {
    return std::all_of(body.told.begin(), body.told.end(), [](bool told) { return told; });
  };
  for (const auto& pair : pairs_) {
    auto &a = bodies_[static_cast<std::size_t>(pair.first)], &b = bodies_[static_cast<std::size_t>(pair.second)];
    if (!all_told(a) || !all_told(b)) continue;
    const double share = first_overlap(a, b);
    if (share > 1.0) continue;
    const auto overlap = overlap_at(a, b, share);
    const double begin_s = problem_.clock.time_s(last_window_), end_s = problem_.clock.time_s(window);
    found.push_back({a.name, b.name, overlap.depth_m, begin_s + share * (end_s - begin_s), begin_s, overlap.place});
  }
  for (auto& body : bodies_) body.before = body.now;
  last_window_ = window;
  return found;
}

}  // namespace ricochet::coupler
