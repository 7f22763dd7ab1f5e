#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "common/problem/contact_pairs.hpp"
#include "common/problem/outline.hpp"
#include "common/problem/rigid_obstacle.hpp"

namespace ricochet::scene {
namespace {

constexpr double depth_tolerance = 1e-9;  ///< of the size of the first body

double size_of(const fem::Mesh& mesh) {
  Eigen::Vector3d low = mesh.position[0], high = low;
  for (const Eigen::Vector3d& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

double start_tolerance(const ContactSide& a, const ContactSide* b) {
  if (a.flat && (b == nullptr || b->flat)) return depth_tolerance * size_of(a.body->mesh);
  return chord_tolerance * (b == nullptr ? a.shortest_edge_m : std::min(a.shortest_edge_m, b->shortest_edge_m));
}

/// Refuses what cannot start: surfaces that overlap, nodes without area, pairs that nothing can move. `b` is null for a
/// rigid plane.
void check_start(const ContactContext& context, const ContactSide& a, const ContactSide* b, ContactPair& pair) {
  const std::string place = place_on(a, a.body->mesh.position[at(pair.node_a)]);
  double motion = 0.0;
  bool held = true;
  for (const auto& [node, weight] : own_nodes(pair)) {
    motion -= weight * initial_motion(a, node, pair.normal);
    held = held && held_along(a, node, pair.normal);
  }
  for (const auto& [node, weight] : pair.b) {
    motion += weight * initial_motion(*b, node, pair.normal);
    held = held && held_along(*b, node, pair.normal);
  }
  const double smallest = std::min(pair.gap0_m, pair.gap0_m + motion);
  if (smallest < -start_tolerance(a, b))
    context.refuse(fmt::format("bodies that overlap by {:.6g} m at {}{}", -smallest, place,
                               pair.gap0_m < -start_tolerance(a, b) ? "" : " after the initial displacement"),
                   "a gap >= 0 at the start: move a mesh by start_m or give initial_gap_m");
  pair.gap0_m = std::max(pair.gap0_m, 0.0);
  if (!(pair.area_m2 > 0.0)) context.refuse("a contact node without area at " + place, "area > 0");
  if (held)
    context.refuse("a pair held along the normal by supports on every side, at " + place,
                   "contact nodes that are free along the normal on one side at least");
}

int index_of(const std::vector<BodyProblem>& bodies, const BodyProblem* body) {
  return static_cast<int>(body - bodies.data());
}

/// A body that turns may touch by an edge of its surface, and only nodes of the one that carries the rows are felt.
bool may_touch_by_edge(const ContactContext& context, const ContactSide& side) {
  return context.scene.body(side.body->name).large_rotation && surface::has_edges(faces_of(side));
}

bool is_rigid(const ContactSide& side) { return side.body->mesh.rigid_nodes > 0; }

/// Nothing would say how much of their energy such bodies keep.
void refuse_rigid_pair(const ContactContext& context, const ContactSide& a, const ContactSide* b) {
  if (!is_rigid(a) || (b != nullptr && !is_rigid(*b))) return;
  context.refuse(b == nullptr ? fmt::format("rigid body \"{}\" against a rigid obstacle", a.body->name)
                              : fmt::format("two rigid bodies, \"{}\" and \"{}\"", a.body->name, b->body->name),
                 "a body that deforms on one side at least");
}

/// The smaller part of two sizes; empty: they are the same.
std::optional<bool> second_is_smaller(double first, double second) {
  const double ratio = second / first;
  return std::abs(ratio - 1.0) > flat_tolerance ? std::optional(ratio < 1.0) : std::nullopt;
}

double mean_face_m2(const ContactSide& side) {
  return std::accumulate(side.area_m2.begin(), side.area_m2.end(), 0.0) / static_cast<double>(side.faces().size());
}

/// The surface named second has the finer mesh, by its shortest edge and then by its faces, or that named first is of a
/// rigid body, of whose nodes few are free; of equal ones the body that comes first carries the rows, so that the order
/// of the names changes nothing. Pairs of nodes are the same either way.
bool second_carries_rows(const ContactContext& context, const ContactSide& a, const ContactSide& b) {
  if (is_rigid(a) || is_rigid(b)) return is_rigid(a);
  if (needs_pairs(context.scene) || a.normal.dot(b.normal) >= 0.0 || match_in_pairs(a, b)) return false;
  const bool edge_of_b = may_touch_by_edge(context, b);
  if (edge_of_b != may_touch_by_edge(context, a)) return edge_of_b;
  if (const auto by_edge = second_is_smaller(a.shortest_edge_m, b.shortest_edge_m)) return *by_edge;
  return second_is_smaller(mean_face_m2(a), mean_face_m2(b)).value_or(b.body < a.body);
}

/// By how much a body reaches out beyond its surface [m]: the other one may meet it there first.
double beyond_surface_m(const ContactSide& side, const Eigen::Vector3d& out) {
  double lowest_m = std::numeric_limits<double>::infinity(), highest_m = -lowest_m, surface_m = -lowest_m;
  for (const Eigen::Vector3d& x : side.body->mesh.position) {
    lowest_m = std::min(lowest_m, x.dot(out));
    highest_m = std::max(highest_m, x.dot(out));
  }
  for (std::size_t i = 0; i < side.nodes.size(); ++i) surface_m = std::max(surface_m, side.position(i).dot(out));
  constexpr double round_off = 1e-6;  // a share of the body
  return highest_m - surface_m > round_off * (highest_m - lowest_m) ? highest_m - surface_m : 0.0;
}

/// A body that is beyond what is rigid at the start counts as in a hole of it.
bool reaches_beyond(const Contact& contact, const ContactSide& a, const ContactSide* b,
                    const ContactGeometry& geometry) {
  if (b != nullptr)
    return beyond_surface_m(a, geometry.touch_normal) > 0.0 || beyond_surface_m(*b, -geometry.touch_normal) > 0.0;
  if (beyond_surface_m(a, geometry.normal) == 0.0) return false;
  const RigidShape shape(contact, geometry, a.body->mesh);
  const auto& places = a.body->mesh.position;
  const double touches_m = flat_tolerance * a.shortest_edge_m;
  return std::all_of(places.begin(), places.end(), [&](const auto& x) { return shape.depth_m(x) <= touches_m; });
}

ContactGeometry build_one(const ContactContext& context, const std::vector<BodyProblem>& bodies) {
  ContactSide a = make_side(context, bodies, context.contact.first, context.contact.normal);
  if (a.flat && !context.contact.normal.empty())
    context.refuse(fmt::format("a normal for surface \"{}\", which is flat", a.name), "no key normal");
  std::optional<ContactSide> b;
  if (context.contact.second) b = make_side(context, bodies, *context.contact.second, {}, Eigen::Vector3d(-a.normal));
  refuse_rigid_pair(context, a, b ? &*b : nullptr);
  ContactGeometry geometry;
  geometry.name = context.contact.name;
  geometry.named_normal = a.normal;
  if (b && second_carries_rows(context, a, *b)) {
    geometry.second_named_first = true;
    std::swap(a, *b);
    if (!a.flat) a.normal = -geometry.named_normal;
  }
  geometry.body_a = index_of(bodies, a.body);
  geometry.body_b = b ? index_of(bodies, b->body) : -1;
  geometry.normal = a.normal;
  if (b) {
    set_pairs(context, a, *b, geometry);
  } else {
    set_rigid_pairs(context, a, geometry);
  }
  carry(a.body->mesh, b ? &b->body->mesh : nullptr, geometry.pairs);
  geometry.reaches_beyond = reaches_beyond(context.contact, a, b ? &*b : nullptr, geometry);
  geometry.matching =
      std::all_of(geometry.pairs.begin(), geometry.pairs.end(), [](const ContactPair& p) { return p.b.size() <= 1; });
  for (auto& pair : geometry.pairs) check_start(context, a, b ? &*b : nullptr, pair);
  sort_by_distance(geometry.pairs);
  return geometry;
}

}  // namespace

std::vector<ContactGeometry> build_contacts(const Scene& scene, const std::vector<BodyProblem>& bodies) {
  std::vector<ContactGeometry> contacts;
  for (const Contact& contact : scene.contacts) contacts.push_back(build_one({scene, contact}, bodies));
  return contacts;
}

std::vector<int> contact_nodes(const std::vector<ContactGeometry>& contacts, int body) {
  std::vector<int> nodes;
  for (const ContactGeometry& contact : contacts) {
    const std::vector<int> own = contact_nodes(contact, body);
    nodes.insert(nodes.end(), own.begin(), own.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<int> contact_nodes(const ContactGeometry& contact, int body) {
  std::vector<int> nodes;
  for (const ContactPair& pair : contact.pairs) {
    for (const auto& own : own_nodes(pair)) {
      if (body == contact.body_a) nodes.push_back(own.node);
    }
    for (const auto& opposite : pair.b) {
      if (body == contact.body_b) nodes.push_back(opposite.node);
    }
  }
  const auto& [of_a, of_b] = contact.sliding_nodes;
  if (body == contact.body_a) nodes.insert(nodes.end(), of_a.begin(), of_a.end());
  if (body == contact.body_b) nodes.insert(nodes.end(), of_b.begin(), of_b.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace ricochet::scene
