#include "common/problem/contact_pairs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

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

/// Pairs of nodes where they match, else none.
std::vector<ContactPair> matching_pairs(const ContactContext& context, const ContactSide& a, const ContactSide& b) {
  std::vector<ContactPair> pairs;
  const bool parallel = a.flat && b.flat && a.normal.dot(b.normal) <= flat_tolerance - 1.0;
  if (!parallel) {
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

std::vector<ContactPair> mortar_pairs(const ContactMesh& mesh, const Eigen::Vector3d& shift_m) {
  std::vector<ContactPair> pairs;
  for (auto& row : mesh.second.rows(mesh.first, shift_m))
    pairs.push_back(
        {.node_a = row.node, .b = std::move(row.opposite), .normal = mesh.normal.at(row.node), .area_m2 = row.area_m2});
  return pairs;
}

/// Of the meshes, along the pair's normal, where nodes of the second lie opposite.
double mesh_distance(const fem::Mesh& mesh_a, const fem::Mesh& mesh_b, const ContactPair& pair) {
  const Eigen::Vector3d& x = mesh_a.position[at(pair.node_a)];
  Eigen::Vector3d opposite = Eigen::Vector3d::Zero();
  for (const auto& [node, weight] : pair.b)
    opposite += weight * fem::nearest_image(mesh_b, mesh_b.position[at(node)], x);
  return (opposite - x).dot(pair.normal);
}

}  // namespace

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

ContactMesh mesh_of(const ContactSide& a, const ContactSide& b) {
  const bool flat = a.flat && b.flat;
  const auto along = flat ? std::optional(tangent_of(a.normal)) : std::nullopt;
  ContactMesh mesh{
      faces_of(a), OppositeFaces(faces_of(b), along, {a.body->mesh.period_m, a.body->mesh.period_wide_m}), {}};
  const std::vector<Eigen::Vector3d> normals = nodal_normals(a);
  for (std::size_t i = 0; i < normals.size(); ++i) mesh.normal.emplace(a.nodes[i], normals[i]);
  return mesh;
}

void complete(const Contact& contact, const fem::Mesh& mesh_a, double apart_m, ContactPair& pair) {
  pair.distance_m = mesh_a.position[at(pair.node_a)][0];
  pair.gap0_m = apart_m + contact.initial_gap_m;
  if (contact.nose_radius_m > 0.0) pair.gap0_m += pair.distance_m * pair.distance_m / (2.0 * contact.nose_radius_m);
}

void sort_by_distance(std::vector<ContactPair>& pairs) {
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const ContactPair& p, const ContactPair& q) { return p.distance_m < q.distance_m; });
}

std::vector<ContactPair> pairs_of(const ContactContext& context, const ContactSide& a, const ContactSide& b) {
  const auto numbers = [&](const Eigen::Vector3d& x) {
    return fmt::format("({:.4g})", fmt::join(x.data(), x.data() + context.scene.components(), ", "));
  };
  if (a.normal.dot(b.normal) >= 0.0)
    context.refuse(fmt::format("outward normals {} and {}", numbers(a.normal), numbers(b.normal)),
                   "surfaces that face each other");
  std::vector<ContactPair> pairs = matching_pairs(context, a, b);
  if (pairs.empty()) pairs = mortar_pairs(mesh_of(a, b), Eigen::Vector3d::Zero());
  if (pairs.empty())
    context.refuse(fmt::format("surfaces \"{}\" and \"{}\" that lie nowhere opposite each other", a.name, b.name),
                   "surfaces that face each other along a part of them at least");
  const fem::Mesh &mesh_a = a.body->mesh, &mesh_b = b.body->mesh;
  for (auto& pair : pairs) {
    const double apart_m = a.flat && b.flat ? (b.point - mesh_a.position[at(pair.node_a)]).dot(a.normal)
                                            : mesh_distance(mesh_a, mesh_b, pair);
    complete(context.contact, mesh_a, apart_m, pair);
  }
  return pairs;
}

std::vector<ContactPair> slid_pairs(const Problem& problem, std::size_t index, const Eigen::Vector3d& shift_m) {
  const ContactGeometry& geometry = problem.contacts[index];
  const fem::Mesh &mesh_a = problem.bodies[at(geometry.body_a)].mesh,
                  &mesh_b = problem.bodies[at(geometry.body_b)].mesh;
  std::vector<ContactPair> pairs = mortar_pairs(*geometry.sliding, shift_m);
  for (auto& pair : pairs) complete(problem.scene.contacts[index], mesh_a, mesh_distance(mesh_a, mesh_b, pair), pair);
  sort_by_distance(pairs);
  return pairs;
}

}  // namespace ricochet::scene
