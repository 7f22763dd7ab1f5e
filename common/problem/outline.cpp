#include "common/problem/outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

/// Share of the shortest edge that an overlap must exceed.
constexpr double tolerated_share = 0.01;

std::vector<std::array<int, 2>> boundary_edges(const fem::Mesh& mesh) {
  std::map<std::array<int, 2>, std::pair<int, std::array<int, 2>>> count;
  for (const auto& element : mesh.elements) {
    for (const auto& [a, b] : fem::traits(element.kind).faces) {
      const std::array<int, 2> edge{element[at(a)], element[at(b)]};
      auto& entry = count[{std::min(edge[0], edge[1]), std::max(edge[0], edge[1])}];
      ++entry.first;
      entry.second = edge;
    }
  }
  std::vector<std::array<int, 2>> edges;
  for (const auto& [ends, entry] : count)
    if (entry.first == 1) edges.push_back(entry.second);
  return edges;
}

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double share = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - share * along).norm();
}

}  // namespace

Outline outline_of(const fem::Mesh& mesh) {
  Outline outline;
  std::vector<std::array<int, 2>> edges;
  std::vector<int> elements_at(mesh.position.size(), 0);
  if (mesh.model == Model::bar) {
    for (const auto& element : mesh.elements)
      for (const int node : element) ++elements_at[at(node)];
    for (int node = 0; node < static_cast<int>(elements_at.size()); ++node)
      if (elements_at[at(node)] == 1) outline.nodes.push_back(node);
    return outline;
  }
  edges = boundary_edges(mesh);
  for (const auto& edge : edges) outline.nodes.insert(outline.nodes.end(), edge.begin(), edge.end());
  std::sort(outline.nodes.begin(), outline.nodes.end());
  outline.nodes.erase(std::unique(outline.nodes.begin(), outline.nodes.end()), outline.nodes.end());
  const auto index = [&](int node) {
    return static_cast<int>(std::lower_bound(outline.nodes.begin(), outline.nodes.end(), node) - outline.nodes.begin());
  };
  for (const auto& edge : edges) outline.edges.push_back({index(edge[0]), index(edge[1])});
  return outline;
}

std::vector<BodyPair> pairs_without_contact(const Problem& problem) {
  std::vector<BodyPair> pairs;
  const int bodies = static_cast<int>(problem.bodies.size());
  const int low = std::min(problem.contact.body_a, problem.contact.body_b);
  const int high = std::max(problem.contact.body_a, problem.contact.body_b);
  for (int i = 0; i < bodies; ++i)
    for (int j = i + 1; j < bodies; ++j)
      if (i != low || j != high) pairs.push_back({i, j});
  return pairs;
}

Shape::Shape(const BodyProblem& body) : outline_(outline_of(body.mesh)) {
  if (body.section.model == Model::bar) last_axis_ = 0;
  if (body.mesh.period_m > 0.0) first_axis_ = 1;
  for (const int node : outline_.nodes) reference_.push_back(body.mesh.position[at(node)]);
  shortest_edge_m_ = std::numeric_limits<double>::infinity();
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e)
    shortest_edge_m_ = std::min(shortest_edge_m_, fem::edge_lengths(fem::element_geometry(body.mesh, e)).shortest);
  move(std::vector<Eigen::Vector2d>(reference_.size(), Eigen::Vector2d::Zero()));
}

void Shape::move(const std::vector<Eigen::Vector2d>& displacement) {
  x_ = reference_;
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += displacement[i];
  low_ = high_ = x_.front();
  for (const auto& x : x_) {
    low_ = low_.cwiseMin(x);
    high_ = high_.cwiseMax(x);
  }
}

double Shape::thickness() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (int axis = first_axis_; axis <= last_axis_; ++axis) smallest = std::min(smallest, high_[axis] - low_[axis]);
  return smallest;
}

bool Shape::boxes_meet(const Shape& other) const {
  for (int axis = std::max(first_axis_, other.first_axis_); axis <= last_axis_; ++axis)
    if (high_[axis] <= other.low_[axis] || other.high_[axis] <= low_[axis]) return false;
  return true;
}

double Shape::depth(const Eigen::Vector2d& p) const {
  bool inside = false;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& edge : outline_.edges) {
    const Eigen::Vector2d &a = x_[at(edge[0])], &b = x_[at(edge[1])];
    nearest = std::min(nearest, distance_to_segment(p, a, b));
    const bool crosses = (a[1] > p[1]) != (b[1] > p[1]);
    if (crosses && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside ? nearest : -nearest;
}

void Shape::add_points_within(const Shape& other, Overlap& worst) const {
  const auto add = [&](const Eigen::Vector2d& place) {
    if ((place.array() <= other.low_.array()).any() || (place.array() >= other.high_.array()).any()) return;
    const double depth_m = other.depth(place);
    if (depth_m > worst.depth_m) worst = {depth_m, place};
  };
  for (const auto& x : x_) add(x);
  for (const auto& edge : outline_.edges) add(0.5 * (x_[at(edge[0])] + x_[at(edge[1])]));
}

Shape::Overlap Shape::overlap(const Shape& other) const {
  Overlap worst;
  if (!boxes_meet(other)) return worst;
  const int first = std::max(first_axis_, other.first_axis_);
  if (first == last_axis_) {
    const double from = std::max(low_[first], other.low_[first]), to = std::min(high_[first], other.high_[first]);
    worst.depth_m = to - from;
    worst.place = 0.5 * (low_ + high_);
    worst.place[first] = 0.5 * (from + to);
    return worst;
  }
  add_points_within(other, worst);
  other.add_points_within(*this, worst);
  return worst;
}

double overlap_tolerance(const Shape& a, const Shape& b) {
  return tolerated_share * std::min(a.shortest_edge(), b.shortest_edge());
}

}  // namespace ricochet::scene
