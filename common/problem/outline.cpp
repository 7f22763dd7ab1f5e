#include "common/problem/outline.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/fem/boundary.hpp"
#include "common/problem/build.hpp"
#include "common/problem/columns.hpp"

namespace ricochet::scene {
namespace {

/// Share of the shortest edge that an overlap must exceed.
constexpr double tolerated_share = 0.01;
/// The same where a contact has facets and edges between its nodes, and of a penalty, into which bodies sink.
constexpr double share_beside_contact = 0.25, share_beside_penalty = 1.0;

double distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double share = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - share * along).norm();
}

/// Nearest point of a triangle: in its plane if that is inside it, else on its sides.
double distance_to_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a), from_a = p - a;
  const double second = from_a.cross(c - a).dot(normal), third = (b - a).cross(from_a).dot(normal);
  if (second >= 0.0 && third >= 0.0 && second + third <= normal.squaredNorm())
    return std::abs(from_a.dot(normal)) / normal.norm();
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

}  // namespace

Outline outline_of(const fem::Mesh& mesh) {
  Outline outline;
  const auto faces = fem::boundary_faces(mesh);
  for (const auto& [face, element] : faces) outline.nodes.insert(outline.nodes.end(), face.begin(), face.end());
  std::sort(outline.nodes.begin(), outline.nodes.end());
  outline.nodes.erase(std::unique(outline.nodes.begin(), outline.nodes.end()), outline.nodes.end());
  const auto index = [&](int node) {
    return static_cast<int>(std::lower_bound(outline.nodes.begin(), outline.nodes.end(), node) - outline.nodes.begin());
  };
  for (const auto& [face, element] : faces) {
    if (face.size() == 2) outline.edges.push_back({index(face[0]), index(face[1])});
    for (std::size_t i = 2; i < face.size(); ++i)
      outline.triangles.push_back({index(face[0]), index(face[i - 1]), index(face[i])});
  }
  return outline;
}

std::vector<BodyPair> pairs_without_contact(const Problem& problem) {
  std::vector<BodyPair> pairs;
  const int bodies = static_cast<int>(problem.bodies.size());
  const auto touch = [&](int i, int j) {
    return std::any_of(problem.contacts.begin(), problem.contacts.end(), [&](const ContactGeometry& contact) {
      return std::min(contact.body_a, contact.body_b) == i && std::max(contact.body_a, contact.body_b) == j;
    });
  };
  for (int i = 0; i < bodies; ++i)
    for (int j = i + 1; j < bodies; ++j)
      if (!touch(i, j)) pairs.push_back({i, j});
  return pairs;
}

std::vector<const ContactGeometry*> contacts_to_watch(const Problem& problem) {
  const auto bodies = [&](std::size_t i) {
    return std::minmax({problem.contacts[i].body_a, problem.contacts[i].body_b});
  };
  const auto lies_by_its_mesh = [&](std::size_t i) {
    for (std::size_t other = 0; other < problem.contacts.size(); ++other) {
      if (bodies(other) != bodies(i)) continue;
      const Contact& spec = problem.scene.contacts[other];
      if (spec.nose_radius_m > 0.0 || (other != i && spec.initial_gap_m != problem.scene.contacts[i].initial_gap_m))
        return false;
    }
    return true;
  };
  std::vector<const ContactGeometry*> contacts;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactGeometry& contact = problem.contacts[i];
    const bool turns = contact.turns || problem.scene.body(problem.bodies[at(contact.body_a)].name).large_rotation;
    if ((turns || contact.sliding || contact.reaches_beyond) && lies_by_its_mesh(i)) contacts.push_back(&contact);
  }
  return contacts;
}

Shape::Shape(const BodyProblem& body) : outline_(outline_of(body.mesh)) {
  last_axis_ = fem::components(body.section.model) - 1;
  if (body.mesh.period_m > 0.0) first_axis_ = body.mesh.period_wide_m > 0.0 ? 2 : 1;
  for (const int node : outline_.nodes) reference_.push_back(body.mesh.position[at(node)]);
  shortest_edge_m_ = std::numeric_limits<double>::infinity();
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e)
    shortest_edge_m_ = std::min(shortest_edge_m_, fem::edge_lengths(fem::element_geometry(body.mesh, e)).shortest);
  move(std::vector<Eigen::Vector3d>(reference_.size(), Eigen::Vector3d::Zero()));
}

void Shape::move(const std::vector<Eigen::Vector3d>& displacement) {
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

/// A place that is `tolerance_m` deep has all within that around it.
double Shape::depth_in_solid(const Columns& columns, const Eigen::Vector3d& p, double tolerance_m) const {
  for (int side = 0; side < 7; ++side) {
    Eigen::Vector3d beside = p;
    if (side > 0) beside[(side - 1) / 2] += side % 2 == 0 ? tolerance_m : -tolerance_m;
    if (!columns.within(beside)) return 0.0;
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [i, j, k] : outline_.triangles)
    nearest = std::min(nearest, distance_to_triangle(p, x_[at(i)], x_[at(j)], x_[at(k)]));
  return nearest;
}

double Shape::depth(const Eigen::Vector3d& p) const {
  bool inside = false;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& edge : outline_.edges) {
    const Eigen::Vector3d &a = x_[at(edge[0])], &b = x_[at(edge[1])];
    nearest = std::min(nearest, distance_to_segment(p, a, b));
    const bool crosses = (a[1] > p[1]) != (b[1] > p[1]);
    if (crosses && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside ? nearest : -nearest;
}

void Shape::add_points_within(const Shape& other, double tolerance_m, Overlap& worst) const {
  const bool solid = !other.outline_.triangles.empty();
  const Columns columns(other.outline_.triangles, other.x_, other.low_, other.high_, other.shortest_edge_m_);
  const auto add = [&](const Eigen::Vector3d& place) {
    for (int axis = 0; axis <= last_axis_; ++axis)
      if (place[axis] <= other.low_[axis] || place[axis] >= other.high_[axis]) return;
    const double depth_m =
        solid ? other.depth_in_solid(columns, place, std::max(tolerance_m, worst.depth_m)) : other.depth(place);
    if (depth_m > worst.depth_m) worst = {depth_m, place};
  };
  for (const auto& x : x_) add(x);
  for (const auto& edge : outline_.edges) add(0.5 * (x_[at(edge[0])] + x_[at(edge[1])]));
  for (const auto& [i, j, k] : outline_.triangles) add((x_[at(i)] + x_[at(j)] + x_[at(k)]) / 3.0);
}

const Eigen::Vector3d& Shape::furthest(const Eigen::Vector3d& direction) const {
  return *std::max_element(x_.begin(), x_.end(),
                           [&](const auto& x, const auto& y) { return x.dot(direction) < y.dot(direction); });
}

/// Looks for a direction along which all of one comes before all of the other, as there is one between convex bodies
/// that are apart: the difference of the places that overlap most along the last one is mirrored (Chung, Wang 1996).
bool Shape::plane_between(const Shape& other, double tolerance_m) const {
  constexpr int tries = 20;
  Eigen::Vector3d direction = (other.low_ + other.high_ - low_ - high_).normalized();
  if (direction.isZero(0.0)) return false;
  for (int i = 0; i < tries; ++i) {
    const Eigen::Vector3d apart = other.furthest(-direction) - furthest(direction);
    const double gap_m = apart.dot(direction);
    if (gap_m >= -tolerance_m) return true;
    direction -= 2.0 * gap_m / apart.squaredNorm() * apart;
  }
  return false;
}

Shape::Overlap Shape::overlap(const Shape& other, double tolerance_m) const {
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
  if (plane_between(other, tolerance_m)) return worst;
  add_points_within(other, tolerance_m, worst);
  other.add_points_within(*this, tolerance_m, worst);
  return worst;
}

const Eigen::Vector3d& Shape::deepest(const RigidShape& rigid) const {
  return *std::max_element(x_.begin(), x_.end(),
                           [&](const auto& x, const auto& y) { return rigid.depth_m(x) < rigid.depth_m(y); });
}

RigidShape::RigidShape(const Contact& contact, const ContactGeometry& geometry, const fem::Mesh& mesh_a) {
  if (!geometry.round) {
    const ContactPair& pair = geometry.pairs.front();
    direction_ = geometry.normal;
    place_m_ = mesh_a.position[at(pair.node_a)] + pair.gap0_m * direction_;
    return;
  }
  radius_m_ = contact.rigid_radius_m;
  direction_ = Eigen::Vector3d::Zero();
  if (contact.obstacle == Obstacle::cylinder)
    direction_[mesh_a.model == fem::Model::solid ? contact.rigid_axis : 2] = 1.0;
  place_m_ = geometry.middle_m;
}

double RigidShape::depth_m(const Eigen::Vector3d& place) const {
  const Eigen::Vector3d way = place - place_m_;
  const double along_m = way.dot(direction_);
  return radius_m_ == 0.0 ? along_m : radius_m_ - (way - along_m * direction_).norm();
}

double overlap_tolerance(const Shape& a, const Shape& b) {
  return tolerated_share * std::min(a.shortest_edge(), b.shortest_edge());
}

double overlap_tolerance(const Shape& a, const Shape& b, const Contact& law, const ContactGeometry& contact) {
  const bool sinks = law.enforcement == Enforcement::penalty;
  const double share = sinks ? share_beside_penalty : share_beside_contact;
  return share * std::min(a.shortest_edge(), b.shortest_edge()) + contact.off_faces_m;
}

}  // namespace ricochet::scene
