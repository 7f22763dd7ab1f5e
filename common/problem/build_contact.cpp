#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

constexpr double flat_tolerance = 1e-6;   ///< of the shortest edge; also of a unit normal
constexpr double depth_tolerance = 1e-9;  ///< of the size of the first body

const char* const surfaces_key = "contact.surfaces";

/// One side of the contact: nodes sorted along the surface, their tributary areas, and where the surface lies.
struct Side {
  std::string name;
  const BodyProblem* body = nullptr;
  std::vector<int> nodes;
  std::vector<double> area_m2;
  Eigen::Vector3d normal{0.0, 0.0, 0.0};  ///< outward
  Eigen::Vector3d point{0.0, 0.0, 0.0};
  double shortest_edge_m = std::numeric_limits<double>::infinity();

  [[nodiscard]] const Eigen::Vector3d& position(std::size_t i) const { return body->mesh.position[at(nodes[i])]; }
};

std::string text(const Side& side, const Eigen::Vector3d& x) {
  if (side.body->section.model == Model::solid) return fmt::format("({:.9g}, {:.9g}, {:.9g}) m", x[0], x[1], x[2]);
  return fmt::format("({:.9g}, {:.9g}) m", x[0], x[1]);
}

[[noreturn]] void refuse(const Scene& scene, const std::string& found, const std::string& allowed) {
  throw ConfigError(fmt::format("{}: found {}; allowed: {}", scene.where(surfaces_key), found, allowed));
}

/// Outward normal at the end of a bar: away from the other node of its element.
Eigen::Vector3d bar_normal(const fem::Mesh& mesh, int node) {
  double other = 0.0;
  for (const auto& element : mesh.elements) {
    if (element[0] == node) other = mesh.position[at(element[1])][0];
    if (element[1] == node) other = mesh.position[at(element[0])][0];
  }
  return {mesh.position[at(node)][0] > other ? 1.0 : -1.0, 0.0, 0.0};
}

/// Shortest side of a face.
double shortest_side(const fem::Mesh& mesh, const fem::Face& face) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < face.size() || (face.size() > 2 && i < face.size()); ++i) {
    const Eigen::Vector3d& a = mesh.position[at(face[i])];
    const Eigen::Vector3d b = fem::nearest_image(mesh, mesh.position[at(face[(i + 1) % face.size()])], a);
    shortest = std::min(shortest, (b - a).norm());
  }
  return shortest;
}

void require_flat(const Scene& scene, const Side& side) {
  const fem::Mesh& mesh = side.body->mesh;
  const bool solid = scene.model == Model::solid;
  for (std::size_t i = 0; i < side.nodes.size(); ++i)
    if (std::abs((side.position(i) - side.point).dot(side.normal)) > flat_tolerance * side.shortest_edge_m)
      refuse(scene,
             fmt::format("surface \"{}\", whose node at {} lies off the {} through {}", side.name,
                         text(side, side.position(i)), solid ? "plane" : "line", text(side, side.point)),
             "flat surfaces");
  for (const fem::Face& face : mesh.surfaces.at(side.name.substr(side.name.find('.') + 1)))
    if (fem::face_normal(mesh, face).dot(side.normal) < 1.0 - flat_tolerance)
      refuse(scene, fmt::format("surface \"{}\", whose {} face different ways", side.name, solid ? "faces" : "edges"),
             "flat surfaces");
}

void take_faces(const std::vector<fem::Face>& faces, Side& side) {
  const fem::Mesh& mesh = side.body->mesh;
  std::vector<double> area(mesh.position.size(), 0.0);
  for (const fem::Face& face : faces) {
    const fem::FaceArea nodal = fem::face_area(side.body->section, mesh, face);
    for (std::size_t i = 0; i < face.size(); ++i) area[at(face[i])] += nodal[i];
    side.shortest_edge_m = std::min(side.shortest_edge_m, shortest_side(mesh, face));
  }
  for (const int node : side.nodes) side.area_m2.push_back(area[at(node)]);
}

Side make_side(const Scene& scene, const std::vector<BodyProblem>& bodies, const SurfaceName& name) {
  Side side;
  side.name = name.body + "." + name.surface;
  side.body = &*std::find_if(bodies.begin(), bodies.end(), [&](const BodyProblem& b) { return b.name == name.body; });
  const fem::Mesh& mesh = side.body->mesh;
  require_surface(scene, surfaces_key, mesh, name.surface);
  const auto& faces = mesh.surfaces.at(name.surface);
  side.nodes = fem::surface_nodes(mesh, name.surface);
  take_faces(faces, side);
  side.point = side.position(0);
  side.normal = scene.model == Model::bar ? bar_normal(mesh, side.nodes[0]) : fem::face_normal(mesh, faces[0]);
  if (scene.model == Model::bar && side.nodes.size() > 1)
    refuse(scene, fmt::format("surface \"{}\" of {} nodes", side.name, side.nodes.size()), "one end of a bar");
  if (scene.model != Model::bar) require_flat(scene, side);
  return side;
}

/// Indices of a side's nodes by their coordinate along `tangent`.
std::vector<std::pair<double, std::size_t>> sorted_along(const Side& side, const Eigen::Vector3d& tangent) {
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

Matches match(const Side& a, const Side& b) {
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
      apart.emplace_back(place, a.name + " " + text(a, x));
      continue;
    }
    found.partner[i] = other->second;
    taken[other->second] = true;
  }
  for (const auto& [place, j] : along_b)
    if (!taken[j]) apart.emplace_back(place, b.name + " " + text(b, b.position(j)));
  std::stable_sort(apart.begin(), apart.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
  for (const auto& [place, node] : apart) found.lonely.push_back(node);
  return found;
}

/// A law that moves masses or weighs by impedances pair by pair needs pairs of nodes, and so do solids.
void require_matching(const Scene& scene, std::vector<std::string> lonely) {
  const auto& law = *scene.contact;
  const bool massless = law.multiplier_update == MultiplierUpdate::massless;
  const bool by_impedance = law.enforcement == Enforcement::penalty && law.impact_update == ImpactUpdate::impedance;
  const bool solid = scene.components() == 3;
  if (!massless && !by_impedance && !solid) return;
  const std::size_t count = lonely.size();
  lonely.resize(std::min<std::size_t>(count, 4));
  refuse(scene,
         fmt::format("{} nodes without a partner at the same place along the surface: {}{}", count,
                     fmt::join(lonely, ", "), count > lonely.size() ? ", ..." : ""),
         fmt::format("with {} surfaces whose nodes face each other in pairs", solid ? "model = \"solid\""
                                                                              : massless
                                                                                  ? "multiplier_update = \"massless\""
                                                                                  : "impact_update = \"impedance\""));
}

/// A side's edges along a line; areas as `take_edges` has them.
std::vector<SurfaceEdge> edges_along(const Side& side, const Eigen::Vector3d& tangent) {
  const fem::Mesh& mesh = side.body->mesh;
  const auto& section = side.body->section;
  const auto measure = [&](const Eigen::Vector3d& x) {
    return section.measure * (section.model == Model::axisymmetric ? x[0] : 1.0);
  };
  std::vector<SurfaceEdge> edges;
  for (const auto& nodes : mesh.surfaces.at(side.name.substr(side.name.find('.') + 1))) {
    const Eigen::Vector3d& a = mesh.position[at(nodes[0])];
    const Eigen::Vector3d b = fem::nearest_image(mesh, mesh.position[at(nodes[1])], a);
    SurfaceEdge edge{{nodes[0], nodes[1]}, {tangent.dot(a), tangent.dot(b)}, {measure(a), measure(b)}};
    if (edge.along_m[0] > edge.along_m[1]) {
      std::swap(edge.node[0], edge.node[1]);
      std::swap(edge.along_m[0], edge.along_m[1]);
      std::swap(edge.measure[0], edge.measure[1]);
    }
    edges.push_back(edge);
  }
  return edges;
}

double size_of(const fem::Mesh& mesh) {
  Eigen::Vector3d low = mesh.position[0], high = low;
  for (const Eigen::Vector3d& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

/// Displacement along the normal at t = 0.
double initial_motion(const Side& side, int node, const Eigen::Vector3d& normal) {
  const int components = fem::components(side.body->section.model);
  double u = 0.0;
  for (int c = 0; c < components; ++c) u += normal[c] * side.body->initial_displacement_m[node * components + c];
  return u;
}

bool held_along(const Side& side, int node, const Eigen::Vector3d& normal) {
  const int components = fem::components(side.body->section.model);
  bool held = true;
  for (int c = 0; c < components; ++c)
    if (std::abs(normal[c]) > flat_tolerance) held = held && side.body->fixed_dof[at(node * components + c)];
  return held;
}

/// Gap of a pair whose node of the first surface, those opposite and area are known; `b` is null for a rigid plane.
void complete(const Scene& scene, const Side& a, const Side* b, ContactPair& pair) {
  const Eigen::Vector3d& x = a.body->mesh.position[at(pair.node_a)];
  pair.distance_m = x[0];
  const double distance = b != nullptr ? (b->point - x).dot(a.normal) : 0.0;
  const double nose = scene.contact->nose_radius_m;
  pair.gap0_m = distance + scene.contact->initial_gap_m;
  if (nose > 0.0) pair.gap0_m += pair.distance_m * pair.distance_m / (2.0 * nose);
  double motion = -initial_motion(a, pair.node_a, a.normal);
  bool held = held_along(a, pair.node_a, a.normal);
  for (const auto& [node, weight] : pair.b) {
    motion += weight * initial_motion(*b, node, a.normal);
    held = held && held_along(*b, node, a.normal);
  }
  const double tolerance = depth_tolerance * size_of(a.body->mesh);
  if (std::min(pair.gap0_m, pair.gap0_m + motion) < -tolerance)
    refuse(scene,
           fmt::format("bodies that overlap by {:.6g} m at {}{}", -std::min(pair.gap0_m, pair.gap0_m + motion),
                       text(a, x), pair.gap0_m < -tolerance ? "" : " after the initial displacement"),
           "a gap >= 0 at the start: move a mesh by start_m or give initial_gap_m");
  pair.gap0_m = std::max(pair.gap0_m, 0.0);
  if (!(pair.area_m2 > 0.0)) refuse(scene, "a contact node without area at " + text(a, x), "area > 0");
  if (held)
    refuse(scene, "a pair held along the normal by supports on every side, at " + text(a, x),
           "contact nodes that are free along the normal on one side at least");
}

/// Pairs of nodes where they match, else rows of the dual mortar.
std::vector<ContactPair> pairs_of(const Scene& scene, const Side& a, const Side& b) {
  const Matches found = match(a, b);
  const bool matching = found.lonely.empty();
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; matching && i < a.nodes.size(); ++i)
    pairs.push_back({.node_a = a.nodes[i], .b = {{b.nodes[found.partner[i]], 1.0}}, .area_m2 = a.area_m2[i]});
  if (matching) return pairs;
  require_matching(scene, found.lonely);
  const Eigen::Vector3d tangent = tangent_of(a.normal);
  for (auto& row : mortar_rows(edges_along(a, tangent), edges_along(b, tangent), a.body->mesh.period_m))
    pairs.push_back({.node_a = row.node, .b = std::move(row.opposite), .area_m2 = row.area_m2});
  if (pairs.empty())
    refuse(scene, fmt::format("surfaces \"{}\" and \"{}\" that lie nowhere opposite each other", a.name, b.name),
           "surfaces that face each other along a part of them at least");
  return pairs;
}

int index_of(const std::vector<BodyProblem>& bodies, const BodyProblem* body) {
  return static_cast<int>(body - bodies.data());
}

}  // namespace

ContactGeometry build_contact(const Scene& scene, const std::vector<BodyProblem>& bodies) {
  ContactGeometry geometry;
  if (!scene.contact) return geometry;
  const Side a = make_side(scene, bodies, scene.contact->first);
  geometry.body_a = index_of(bodies, a.body);
  geometry.normal = a.normal;
  if (scene.contact->second) {
    const Side b = make_side(scene, bodies, *scene.contact->second);
    geometry.body_b = index_of(bodies, b.body);
    if (a.normal.dot(b.normal) > flat_tolerance - 1.0)
      refuse(scene,
             fmt::format("outward normals ({:.4g}) and ({:.4g})",
                         fmt::join(a.normal.data(), a.normal.data() + scene.components(), ", "),
                         fmt::join(b.normal.data(), b.normal.data() + scene.components(), ", ")),
             "surfaces that face each other");
    geometry.pairs = pairs_of(scene, a, b);
    for (auto& pair : geometry.pairs) complete(scene, a, &b, pair);
  } else {
    for (std::size_t i = 0; i < a.nodes.size(); ++i) {
      geometry.pairs.push_back({.node_a = a.nodes[i], .b = {}, .area_m2 = a.area_m2[i]});
      complete(scene, a, nullptr, geometry.pairs.back());
    }
  }
  std::stable_sort(geometry.pairs.begin(), geometry.pairs.end(),
                   [](const ContactPair& p, const ContactPair& q) { return p.distance_m < q.distance_m; });
  return geometry;
}

std::vector<int> contact_nodes(const ContactGeometry& contact, int body) {
  std::vector<int> nodes;
  for (const ContactPair& pair : contact.pairs) {
    if (body == contact.body_a) nodes.push_back(pair.node_a);
    for (const auto& opposite : pair.b) {
      if (body == contact.body_b) nodes.push_back(opposite.node);
    }
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace ricochet::scene
