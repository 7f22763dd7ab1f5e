#include "common/problem/contact_pairs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "common/fem/hanging_nodes.hpp"

namespace ricochet::scene {
namespace {

/// Indices of a side's nodes by their coordinate along `tangent`.
std::vector<std::pair<double, std::size_t>> sorted_along(const ContactSide& side, const Eigen::Vector3d& tangent) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < side.nodes.size(); ++i) order.emplace_back(tangent.dot(side.position(i)), i);
  std::sort(order.begin(), order.end());
  return order;
}

/// Nodes of two surfaces that lie at the same place along them, by their indices, and those that do not.
struct Matches {
  std::vector<std::size_t> partner;  ///< per node of the first surface
  std::vector<std::string> lonely;
};

Matches match(const ContactSide& a, const ContactSide& b) {
  const Eigen::Vector3d tangent = tangent_of(a.normal);
  const auto along_a = sorted_along(a, tangent), along_b = sorted_along(b, tangent);
  const double tolerance = flat_tolerance * std::min(a.shortest_edge_m, b.shortest_edge_m);
  Matches found{std::vector<std::size_t>(a.nodes.size(), 0), {}};
  std::vector<bool> taken(b.nodes.size(), false);
  std::vector<std::pair<double, std::string>> apart;
  for (const auto& [place, i] : along_a) {
    const Eigen::Vector3d x = a.position(i);
    auto other = std::lower_bound(along_b.begin(), along_b.end(), std::pair{place - tolerance, std::size_t{0}});
    const auto opposite = [&](std::size_t j) {
      const Eigen::Vector3d to = b.position(j) - x;
      return !taken[j] && (to - to.dot(a.normal) * a.normal).norm() <= tolerance;
    };
    while (other != along_b.end() && other->first <= place + tolerance && !opposite(other->second)) ++other;
    if (other == along_b.end() || other->first > place + tolerance) {
      apart.emplace_back(place, a.name + " " + place_on(a, x));
      continue;
    }
    found.partner[i] = other->second;
    taken[other->second] = true;
  }
  for (const auto& [place, j] : along_b)
    if (!taken[j]) apart.emplace_back(place, b.name + " " + place_on(b, b.position(j)));
  std::stable_sort(apart.begin(), apart.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
  for (const auto& [place, node] : apart) found.lonely.push_back(node);
  return found;
}

bool flat_and_parallel(const ContactSide& a, const ContactSide& b) {
  return a.flat && b.flat && a.normal.dot(b.normal) <= flat_tolerance - 1.0;
}

/// Pairs of nodes where they match, else none.
std::vector<ContactPair> matching_pairs(const ContactContext& context, const ContactSide& a, const ContactSide& b) {
  std::vector<ContactPair> pairs;
  if (!flat_and_parallel(a, b)) {
    require_matching(context,
                     {fmt::format("those of \"{}\" and \"{}\", which are curved or not parallel", a.name, b.name)});
    return pairs;
  }
  const Matches found = match(a, b);
  if (!found.lonely.empty()) {
    require_matching(context, found.lonely);
    return pairs;
  }
  for (std::size_t i = 0; i < a.nodes.size(); ++i)
    pairs.push_back(
        {.node_a = a.nodes[i], .b = {{b.nodes[found.partner[i]], 1.0}}, .normal = a.normal, .area_m2 = a.area_m2[i]});
  return pairs;
}

surface::ContactMesh mesh_of(const ContactSide& a, const ContactSide& b, bool edges_touch) {
  const auto compliance = [](const ContactSide& side) {
    const fem::Material& material = material_at(*side.body, side.faces().front());
    return (1.0 - material.poisson_ratio * material.poisson_ratio) / material.youngs_modulus_pa;
  };
  return {faces_of(a), surface::OppositeFaces(faces_of(b), {a.body->mesh.period_m, a.body->mesh.period_wide_m}),
          a.shortest_edge_m, compliance(b) / (compliance(a) + compliance(b)), edges_touch};
}

/// Rows with the second surface moved by `shift_m`; its body then stands `moved_m` from where it started.
std::vector<ContactPair> mortar_pairs(const Contact& contact, const fem::Mesh& mesh_a, const surface::ContactMesh& mesh,
                                      const Eigen::Vector3d& shift_m, const Eigen::Vector3d& moved_m) {
  std::vector<ContactPair> pairs;
  for (auto& row : mesh.rows(shift_m)) {
    pairs.push_back({.node_a = row.node,
                     .a = std::move(row.own),
                     .patch = row.patch,
                     .b = std::move(row.opposite),
                     .normal = row.normal,
                     .area_m2 = row.area_m2});
    complete(contact, mesh_a, row.gap_m - moved_m.dot(row.normal), pairs.back());
  }
  return pairs;
}

/// Where bodies of which nothing lies opposite at the start touch if they fly straight on.
std::optional<surface::Touch> touch_in_flight(const surface::ContactMesh& mesh, const Eigen::Vector3d& start_m,
                                              const Eigen::Vector3d& velocity) {
  constexpr int most_moves = 1000;
  if (velocity.isZero(0.0)) return std::nullopt;
  const double move_m = 0.25 * mesh.edge_m;
  const Eigen::Vector3d way = velocity.normalized();
  // One move takes a body no deeper; one that is deeper lies beside the other, not in it.
  const auto deepest_m = [&](const Eigen::Vector3d& normal) {
    return chord_tolerance * mesh.edge_m + move_m * std::abs(way.dot(normal));
  };
  Eigen::Vector3d shift = start_m;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_moves; ++i) {
    const double apart_m = std::max(0.0, mesh.second.apart_m(mesh.first, shift));
    const auto touch = surface::touching(mesh, shift, Eigen::Vector3d::Zero());
    if (touch && touch->gap_m < mesh.edge_m && touch->gap_m > -deepest_m(touch->normal)) return touch;
    if (apart_m > nearest_m + mesh.edge_m) return std::nullopt;  // they fly past
    nearest_m = std::min(nearest_m, apart_m);
    shift += std::max(apart_m, move_m) * way;
  }
  return std::nullopt;
}

/// The largest angle of a normal against a face's own: by so much the place that touches may be another node's.
double largest_turn(const surface::ContactMesh& mesh) {
  double least = 1.0;
  for (const surface::SurfaceFace& face : mesh.first)
    for (std::size_t i = 0; i < face.node.size(); ++i) least = std::min(least, face.normal.dot(face.node_normal[i]));
  return 2.0 * std::acos(std::clamp(least, -1.0, 1.0));
}

/// The normal where curved surfaces touch, but for the mesh.
Eigen::Vector3d normal_of_touch(const surface::ContactMesh& mesh, const ContactSide& a, const Eigen::Vector3d& found) {
  return found.dot(a.normal) >= std::cos(largest_turn(mesh)) ? a.normal : found;
}

/// How far the smooth surface through their nodes, which contact goes by, is from the faces in their middles.
double furthest_from_smooth(const std::vector<surface::SurfaceFace>& faces) {
  double furthest_m = 0.0;
  for (const surface::SurfaceFace& face : faces) {
    surface::ShapeValues middle = surface::ShapeValues::Zero();
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    const double weight = 1.0 / static_cast<double>(face.node.size());
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      middle[static_cast<Eigen::Index>(i)] = weight;
      place += weight * face.x[i];
    }
    furthest_m = std::max(furthest_m, (surface::place_at(face, middle) - place).norm());
  }
  return furthest_m;
}

/// Where curved surfaces touch; of flat ones where they are, unless that is nowhere opposite.
void set_mortar_pairs(const ContactContext& context, const ContactSide& a, const ContactSide& b,
                      const surface::ContactMesh& mesh, ContactGeometry& geometry) {
  const auto pairs = [&] {
    return mortar_pairs(context.contact, a.body->mesh, mesh, geometry.shift_m, geometry.shift_m - geometry.lifted_m);
  };
  if (geometry.flat) geometry.pairs = pairs();
  if (!geometry.pairs.empty()) return;
  const bool about_axis = context.scene.model == Model::axisymmetric;
  std::optional<surface::Touch> touch;
  if (!geometry.flat)
    touch =
        surface::touching(mesh, geometry.lifted_m, about_axis ? a.normal : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  if (!touch && !about_axis) touch = touch_in_flight(mesh, geometry.lifted_m, closing_velocity(context.scene, a, &b));
  if (!touch) return;
  geometry.shift_m = touch->shift_m;
  geometry.touch_normal = about_axis ? a.normal : normal_of_touch(mesh, a, touch->normal);
  geometry.pairs = pairs();
}

}  // namespace

bool match_in_pairs(const ContactSide& a, const ContactSide& b) {
  return flat_and_parallel(a, b) && a.nodes.size() == b.nodes.size() && match(a, b).lonely.empty();
}

bool needs_pairs(const Scene& scene) {
  const Contact& law = scene.contact_law();
  return scene.massless_contact() ||
         (law.enforcement == Enforcement::penalty && law.impact_update == ImpactUpdate::impedance);
}

void require_matching(const ContactContext& context, std::vector<std::string> lonely) {
  if (!needs_pairs(context.scene)) return;
  const std::size_t count = lonely.size();
  lonely.resize(std::min<std::size_t>(count, 4));
  context.refuse(fmt::format("{} nodes without a partner at the same place along the surface: {}{}", count,
                             fmt::join(lonely, ", "), count > lonely.size() ? ", ..." : ""),
                 fmt::format("with {} flat surfaces whose nodes face each other in pairs",
                             context.scene.massless_contact() ? "multiplier_update = \"massless\""
                                                              : "impact_update = \"impedance\""));
}

void complete(const Contact& contact, const fem::Mesh& mesh_a, double apart_m, ContactPair& pair) {
  const Eigen::Vector3d& x = mesh_a.position[at(pair.node_a)];
  pair.distance_m = x[0];
  pair.gap0_m = apart_m;
  if (contact.nose_radius_m == 0.0) return;
  const double across_m = mesh_a.model == Model::solid ? std::hypot(x[0], x[1]) : x[0];
  pair.gap0_m += across_m * across_m / (2.0 * contact.nose_radius_m);
}

void sort_by_distance(std::vector<ContactPair>& pairs) {
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const ContactPair& p, const ContactPair& q) { return p.distance_m < q.distance_m; });
}

void set_pairs(const ContactContext& context, const ContactSide& a, const ContactSide& b, ContactGeometry& geometry) {
  const auto numbers = [&](const Eigen::Vector3d& x) {
    return fmt::format("({:.4g})", fmt::join(x.data(), x.data() + context.scene.components(), ", "));
  };
  geometry.turns = context.scene.body(a.body->name).large_rotation || context.scene.body(b.body->name).large_rotation;
  if (a.normal.dot(b.normal) >= 0.0)
    context.refuse(fmt::format("outward normals {} and {}", numbers(a.normal), numbers(b.normal)),
                   std::string("surfaces that face each other") +
                       (geometry.turns ? ", or of a body that turns all sides at once, \"outside\"" : ""));
  const fem::Mesh& mesh_a = a.body->mesh;
  geometry.touch_normal = a.normal;
  geometry.lifted_m = context.contact.initial_gap_m * geometry.named_normal;
  if (geometry.second_named_first) geometry.lifted_m *= -1.0;
  geometry.shift_m = geometry.lifted_m;
  geometry.flat = flat_and_parallel(a, b) && !geometry.turns;
  geometry.pairs = matching_pairs(context, a, b);
  for (auto& pair : geometry.pairs)
    complete(context.contact, mesh_a,
             (b.point - mesh_a.position[at(pair.node_a)]).dot(a.normal) + context.contact.initial_gap_m, pair);
  const bool may_be_written_anew =
      context.scene.model != Model::bar && context.scene.model != Model::axisymmetric && !needs_pairs(context.scene);
  if (!geometry.pairs.empty() && !(may_be_written_anew && may_slide(context.scene, a, &b, a.normal))) return;
  const bool tilted = a.flat && b.flat && !flat_and_parallel(a, b);  // an edge of one meets the other
  const auto mesh = std::make_shared<const surface::ContactMesh>(mesh_of(a, b, geometry.turns || tilted));
  geometry.off_faces_m = furthest_from_smooth(mesh->first) + furthest_from_smooth(mesh->second.faces());
  if (geometry.pairs.empty()) set_mortar_pairs(context, a, b, *mesh, geometry);
  if (geometry.pairs.empty())
    context.refuse(fmt::format("surfaces \"{}\" and \"{}\" that lie nowhere opposite each other", a.name, b.name),
                   "surfaces that face each other along a part of them at least");
  if (!may_be_written_anew || !may_slide(context.scene, a, &b, geometry.touch_normal)) return;
  geometry.sliding = mesh;
  geometry.sliding_nodes = {fem::carriers_of(mesh_a, a.nodes), fem::carriers_of(b.body->mesh, b.nodes)};
}

namespace {

std::vector<surface::SurfaceFace> turned_faces(std::vector<surface::SurfaceFace> faces,
                                               const fem::RigidMotion& motion) {
  for (surface::SurfaceFace& face : faces) {
    face.normal = motion.rotation * face.normal;
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      face.x[i] += motion.displacement(face.x[i]);
      face.node_normal[i] = motion.rotation * face.node_normal[i];
    }
  }
  return faces;
}

}  // namespace

TurnedSurfaces turned_surfaces(const surface::ContactMesh& mesh, const fem::RigidMotion& first,
                               const fem::RigidMotion& second) {
  return {
      first,
      second,
      {turned_faces(mesh.first, first), surface::OppositeFaces(turned_faces(mesh.second.faces(), second), {0.0, 0.0}),
       mesh.edge_m, mesh.first_share, mesh.edges_touch}};
}

namespace {

/// The gap of a pair is gap0 + N u also where the bodies have turned: what N makes of the turn is no gap.
void take_turn_off(const fem::Mesh& first, const fem::Mesh& second, const TurnedSurfaces& turned,
                   std::vector<ContactPair>& pairs) {
  for (ContactPair& pair : pairs) {
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
    for (const auto& [node, weight] : own_nodes(pair))
      moved -= weight * turned.first.displacement(first.position[at(node)]);
    for (const auto& [node, weight] : pair.b) moved += weight * turned.second.displacement(second.position[at(node)]);
    pair.gap0_m -= pair.normal.dot(moved);
  }
}

}  // namespace

std::vector<ContactPair> slid_pairs(const Problem& problem, std::size_t index, const Eigen::Vector3d& shift_m,
                                    const TurnedSurfaces* turned) {
  const ContactGeometry& geometry = problem.contacts[index];
  const fem::Mesh& mesh_a = problem.bodies[at(geometry.body_a)].mesh;
  std::vector<ContactPair> pairs =
      mortar_pairs(problem.scene.contacts[index], mesh_a, turned != nullptr ? turned->mesh : *geometry.sliding, shift_m,
                   shift_m - geometry.lifted_m);
  const fem::Mesh& mesh_b = problem.bodies[at(geometry.body_b)].mesh;
  if (turned != nullptr) take_turn_off(mesh_a, mesh_b, *turned, pairs);
  carry(mesh_a, &mesh_b, pairs);
  sort_by_distance(pairs);
  return pairs;
}

}  // namespace ricochet::scene
