#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

constexpr double flat_tolerance = 1e-6;   ///< of the shortest edge; also of a unit normal
constexpr double depth_tolerance = 1e-9;  ///< of the size of the first body
/// Chords of curved surfaces may cut each other by this share of the shortest edge.
constexpr double chord_tolerance = 0.05;
/// A surface whose normals cancel to this share of its area faces no one way.
constexpr double least_one_sided = 0.1;

/// One side of a contact: nodes sorted along the surface, their tributary areas, and where the surface lies.
struct Side {
  std::string name;
  const BodyProblem* body = nullptr;
  std::vector<int> nodes;
  std::vector<double> area_m2;
  Eigen::Vector3d normal{0.0, 0.0, 0.0};  ///< outward, the mean of a curved surface
  Eigen::Vector3d point{0.0, 0.0, 0.0};   ///< farthest out along it
  double shortest_edge_m = std::numeric_limits<double>::infinity();
  bool flat = true;

  [[nodiscard]] const Eigen::Vector3d& position(std::size_t i) const { return body->mesh.position[at(nodes[i])]; }
  [[nodiscard]] const std::vector<fem::Face>& faces() const {
    return body->mesh.surfaces.at(name.substr(name.find('.') + 1));
  }
};

std::string text(const Side& side, const Eigen::Vector3d& x) {
  if (side.body->section.model == Model::solid) return fmt::format("({:.9g}, {:.9g}, {:.9g}) m", x[0], x[1], x[2]);
  return fmt::format("({:.9g}, {:.9g}) m", x[0], x[1]);
}

/// What is being built: for the texts of errors and the keys of the contact.
struct Context {
  const Scene& scene;
  const Contact& contact;

  [[nodiscard]] std::string key(const char* of) const { return contact.key() + "." + of; }
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    throw ConfigError(fmt::format("{}: found {}; allowed: {}", scene.where(key("surfaces")), found, allowed));
  }
};

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

bool is_flat(const Side& side) {
  for (std::size_t i = 0; i < side.nodes.size(); ++i)
    if (std::abs((side.position(i) - side.point).dot(side.normal)) > flat_tolerance * side.shortest_edge_m)
      return false;
  return std::all_of(side.faces().begin(), side.faces().end(), [&](const fem::Face& face) {
    return fem::face_normal(side.body->mesh, face).dot(side.normal) >= 1.0 - flat_tolerance;
  });
}

/// Area of a face.
double whole_area(const Side& side, const fem::Face& face) {
  const fem::FaceArea nodal = fem::face_area(side.body->section, side.body->mesh, face);
  return std::accumulate(nodal.begin(), nodal.end(), 0.0);
}

/// Of a curved surface the mean of its faces' normals; about an axis what is across it cancels.
Eigen::Vector3d mean_normal(const Context& context, const Side& side, const std::vector<double>& given) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const fem::Face& face : side.faces()) {
    sum += whole_area(side, face) * fem::face_normal(side.body->mesh, face);
    area += whole_area(side, face);
  }
  if (context.scene.model == Model::axisymmetric) sum[0] = 0.0;
  if (!given.empty()) {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < given.size(); ++c) normal[static_cast<Eigen::Index>(c)] = given[c];
    if (normal.dot(sum) > -least_one_sided * area) return normal;
    context.refuse(fmt::format("a normal into surface \"{}\"", side.name), "one out of it");
  }
  if (sum.norm() > least_one_sided * area) return sum.normalized();
  context.refuse(fmt::format("surface \"{}\", which faces all ways", side.name),
                 "the part of it that may touch, as a surface of its own");
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

/// `normal`: of a curved surface, if it is given.
Side make_side(const Context& context, const std::vector<BodyProblem>& bodies, const SurfaceName& name,
               const std::vector<double>& normal) {
  const Model model = context.scene.model;
  Side side;
  side.name = name.body + "." + name.surface;
  side.body = &*std::find_if(bodies.begin(), bodies.end(), [&](const BodyProblem& b) { return b.name == name.body; });
  const fem::Mesh& mesh = side.body->mesh;
  require_surface(context.scene, context.key("surfaces"), mesh, name.surface);
  side.nodes = fem::surface_nodes(mesh, name.surface);
  take_faces(side.faces(), side);
  side.point = side.position(0);
  side.normal = model == Model::bar ? bar_normal(mesh, side.nodes[0]) : fem::face_normal(mesh, side.faces()[0]);
  if (model == Model::bar && side.nodes.size() > 1)
    context.refuse(fmt::format("surface \"{}\" of {} nodes", side.name, side.nodes.size()), "one end of a bar");
  if (model == Model::bar || is_flat(side)) return side;
  side.flat = false;
  side.normal = mean_normal(context, side, normal);
  for (std::size_t i = 0; i < side.nodes.size(); ++i)
    if (side.position(i).dot(side.normal) > side.point.dot(side.normal)) side.point = side.position(i);
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

/// Laws that move masses or weigh by impedances go by pairs of nodes.
bool needs_pairs(const Scene& scene) {
  const Contact& law = scene.contact_law();
  return scene.massless_contact() ||
         (law.enforcement == Enforcement::penalty && law.impact_update == ImpactUpdate::impedance);
}

/// Refuses what has no node opposite, under a law that needs one.
void require_matching(const Context& context, std::vector<std::string> lonely) {
  if (!needs_pairs(context.scene)) return;
  const std::size_t count = lonely.size();
  lonely.resize(std::min<std::size_t>(count, 4));
  context.refuse(fmt::format("{} nodes without a partner at the same place along the surface: {}{}", count,
                             fmt::join(lonely, ", "), count > lonely.size() ? ", ..." : ""),
                 fmt::format("with {} flat surfaces whose nodes face each other in pairs",
                             context.scene.massless_contact() ? "multiplier_update = \"massless\""
                                                              : "impact_update = \"impedance\""));
}

/// Areas as face_area has them.
std::vector<SurfaceFace> faces_of(const Side& side) {
  const fem::Mesh& mesh = side.body->mesh;
  const auto& section = side.body->section;
  std::vector<SurfaceFace> faces;
  for (const fem::Face& nodes : side.faces()) {
    SurfaceFace face{nodes, {}, {}, fem::face_normal(mesh, nodes)};
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      face.x[i] = fem::nearest_image(mesh, mesh.position[at(nodes[i])], mesh.position[at(nodes[0])]);
      face.measure[i] = section.measure * (section.model == Model::axisymmetric ? face.x[i][0] : 1.0);
    }
    faces.push_back(face);
  }
  return faces;
}

/// Per node of a side the mean of the normals of the faces there; on an axis along it, and on a plane of symmetry,
/// which holds the node, in it.
std::vector<Eigen::Vector3d> nodal_normals(const Side& side) {
  if (side.flat) return std::vector<Eigen::Vector3d>(side.nodes.size(), side.normal);
  std::map<int, Eigen::Vector3d> sum;
  for (const fem::Face& face : side.faces()) {
    const Eigen::Vector3d weighted = whole_area(side, face) * fem::face_normal(side.body->mesh, face);
    for (const int node : face) sum.insert({node, Eigen::Vector3d::Zero()}).first->second += weighted;
  }
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t i = 0; i < side.nodes.size(); ++i) {
    Eigen::Vector3d normal = sum.at(side.nodes[i]);
    const int components = fem::components(side.body->section.model);
    Eigen::Vector3d free = normal;
    for (int c = 0; c < components; ++c)
      if (side.body->fixed_dof[at(side.nodes[i] * components + c)]) free[c] = 0.0;
    normals.push_back((free.isZero(0.0) ? normal : free).normalized());
  }
  return normals;
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

/// Sets what a pair's node says, and its gap, the meshes being apart along the normal by `distance_m`.
void complete(const Contact& contact, const fem::Mesh& mesh_a, double distance_m, ContactPair& pair) {
  pair.distance_m = mesh_a.position[at(pair.node_a)][0];
  pair.gap0_m = distance_m + contact.initial_gap_m;
  if (contact.nose_radius_m > 0.0) pair.gap0_m += pair.distance_m * pair.distance_m / (2.0 * contact.nose_radius_m);
}

/// Of the meshes, along the pair's normal, where nodes of the second lie opposite.
double mesh_distance(const fem::Mesh& mesh_a, const fem::Mesh& mesh_b, const ContactPair& pair) {
  const Eigen::Vector3d& x = mesh_a.position[at(pair.node_a)];
  Eigen::Vector3d opposite = Eigen::Vector3d::Zero();
  for (const auto& [node, weight] : pair.b)
    opposite += weight * fem::nearest_image(mesh_b, mesh_b.position[at(node)], x);
  return (opposite - x).dot(pair.normal);
}

void sort_by_distance(std::vector<ContactPair>& pairs) {
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const ContactPair& p, const ContactPair& q) { return p.distance_m < q.distance_m; });
}

/// Gaps of pairs whose nodes are known; `b` is null for a rigid plane.
class Gaps {
 public:
  Gaps(const Context& context, const Side& a, const Side* b) : context_(context), a_(a), b_(b) {}

  void complete(ContactPair& pair) const { scene::complete(context_.contact, a_.body->mesh, distance(pair), pair); }
  /// At the start.
  void check(ContactPair& pair) const {
    const Eigen::Vector3d& x = a_.body->mesh.position[at(pair.node_a)];
    double motion = -initial_motion(a_, pair.node_a, pair.normal);
    bool held = held_along(a_, pair.node_a, pair.normal);
    for (const auto& [node, weight] : pair.b) {
      motion += weight * initial_motion(*b_, node, pair.normal);
      held = held && held_along(*b_, node, pair.normal);
    }
    const double tolerance = both_flat() ? depth_tolerance * size_of(a_.body->mesh) : chord_tolerance * edge_m();
    if (std::min(pair.gap0_m, pair.gap0_m + motion) < -tolerance)
      context_.refuse(
          fmt::format("bodies that overlap by {:.6g} m at {}{}", -std::min(pair.gap0_m, pair.gap0_m + motion),
                      text(a_, x), pair.gap0_m < -tolerance ? "" : " after the initial displacement"),
          "a gap >= 0 at the start: move a mesh by start_m or give initial_gap_m");
    pair.gap0_m = std::max(pair.gap0_m, 0.0);
    if (!(pair.area_m2 > 0.0)) context_.refuse("a contact node without area at " + text(a_, x), "area > 0");
    if (held)
      context_.refuse("a pair held along the normal by supports on every side, at " + text(a_, x),
                      "contact nodes that are free along the normal on one side at least");
  }

 private:
  [[nodiscard]] bool both_flat() const { return a_.flat && (b_ == nullptr || b_->flat); }
  [[nodiscard]] double edge_m() const {
    return b_ == nullptr ? a_.shortest_edge_m : std::min(a_.shortest_edge_m, b_->shortest_edge_m);
  }
  /// Of the meshes, along the normal. A rigid plane touches the first surface where that is farthest out.
  [[nodiscard]] double distance(const ContactPair& pair) const {
    const Eigen::Vector3d& x = a_.body->mesh.position[at(pair.node_a)];
    if (both_flat()) return b_ != nullptr ? (b_->point - x).dot(a_.normal) : 0.0;
    if (b_ == nullptr) return (a_.point - x).dot(a_.normal);
    return mesh_distance(a_.body->mesh, b_->body->mesh, pair);
  }

  const Context& context_;
  const Side &a_, *b_;
};

/// Pairs of nodes where they match, else none.
std::vector<ContactPair> matching_pairs(const Context& context, const Side& a, const Side& b) {
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

ContactMesh mesh_of(const Side& a, const Side& b) {
  const bool flat = a.flat && b.flat;
  const auto along = flat ? std::optional(tangent_of(a.normal)) : std::nullopt;
  ContactMesh mesh{
      faces_of(a), OppositeFaces(faces_of(b), along, {a.body->mesh.period_m, a.body->mesh.period_wide_m}), {}};
  const std::vector<Eigen::Vector3d> normals = nodal_normals(a);
  for (std::size_t i = 0; i < normals.size(); ++i) mesh.normal.emplace(a.nodes[i], normals[i]);
  return mesh;
}

/// Pairs of nodes where they match, else rows of the dual mortar.
std::vector<ContactPair> pairs_of(const Context& context, const Side& a, const Side& b) {
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
  return pairs;
}

int index_of(const std::vector<BodyProblem>& bodies, const BodyProblem* body) {
  return static_cast<int>(body - bodies.data());
}

/// Against a rigid plane.
std::vector<ContactPair> plane_pairs(const Side& a) {
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; i < a.nodes.size(); ++i)
    pairs.push_back({.node_a = a.nodes[i], .b = {}, .normal = a.normal, .area_m2 = a.area_m2[i]});
  return pairs;
}

/// Something moves the bodies along each other from the start, or may.
bool may_slide(const Scene& scene, const Side& a, const Side& b) {
  const auto along = [&](const std::vector<double>& x) {
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < x.size(); ++c) vector[static_cast<Eigen::Index>(c)] = x[c];
    return Eigen::Vector3d(vector - vector.dot(a.normal) * a.normal);
  };
  const auto driven = [&](const Body& body) {
    const auto pulled = [&](const Traction& traction) { return !along(traction.traction_pa).isZero(0.0); };
    const auto moved = [&](const PrescribedDisplacement& p) { return std::abs(a.normal[p.component]) < 1.0; };
    return !along(body.gravity_m_s2).isZero(0.0) || std::any_of(body.tractions.begin(), body.tractions.end(), pulled) ||
           std::any_of(body.prescribed.begin(), body.prescribed.end(), moved);
  };
  const Body &first = scene.body(a.body->name), &second = scene.body(b.body->name);
  const Eigen::Vector3d closing = along(first.initial_velocity_m_s) - along(second.initial_velocity_m_s);
  return !closing.isZero(0.0) || driven(first) || driven(second);
}

ContactGeometry build_one(const Context& context, const std::vector<BodyProblem>& bodies) {
  const Side a = make_side(context, bodies, context.contact.first, context.contact.normal);
  if (a.flat && !context.contact.normal.empty())
    context.refuse(fmt::format("a normal for surface \"{}\", which is flat", a.name), "no key normal");
  std::optional<Side> b;
  if (context.contact.second) b = make_side(context, bodies, *context.contact.second, {});
  ContactGeometry geometry;
  geometry.name = context.contact.name;
  geometry.body_a = index_of(bodies, a.body);
  geometry.body_b = b ? index_of(bodies, b->body) : -1;
  geometry.normal = a.normal;
  geometry.pairs = b ? pairs_of(context, a, *b) : plane_pairs(a);
  geometry.matching =
      std::all_of(geometry.pairs.begin(), geometry.pairs.end(), [](const ContactPair& p) { return p.b.size() <= 1; });
  const Gaps gaps(context, a, b ? &*b : nullptr);
  for (auto& pair : geometry.pairs) {
    gaps.complete(pair);
    gaps.check(pair);
  }
  sort_by_distance(geometry.pairs);
  const bool two_dimensions_or_three = context.scene.model != Model::bar && context.scene.model != Model::axisymmetric;
  if (b && two_dimensions_or_three && !needs_pairs(context.scene) && may_slide(context.scene, a, *b))
    geometry.sliding = std::make_shared<const ContactMesh>(mesh_of(a, *b));
  return geometry;
}

}  // namespace

std::vector<ContactGeometry> build_contacts(const Scene& scene, const std::vector<BodyProblem>& bodies) {
  std::vector<ContactGeometry> contacts;
  for (const Contact& contact : scene.contacts) contacts.push_back(build_one({scene, contact}, bodies));
  return contacts;
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
    if (body == contact.body_a) nodes.push_back(pair.node_a);
    for (const auto& opposite : pair.b) {
      if (body == contact.body_b) nodes.push_back(opposite.node);
    }
  }
  const auto add = [&](const std::vector<SurfaceFace>& faces) {
    for (const auto& face : faces) nodes.insert(nodes.end(), face.node.begin(), face.node.end());
  };
  if (contact.sliding && body == contact.body_a) add(contact.sliding->first);
  if (contact.sliding && body == contact.body_b) add(contact.sliding->second.faces());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace ricochet::scene
