#include "common/problem/contact_side.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/error.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/contact_pairs.hpp"

namespace ricochet::scene {
namespace {

/// A surface whose normals cancel to this share of its area faces no one way.
constexpr double least_one_sided = 0.1;
/// A vector whose part across the normal is a smaller share of it lies along the normal, but for rounding.
constexpr double direction_tolerance = 1e-9;

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

bool is_flat(const ContactSide& side) {
  for (std::size_t i = 0; i < side.nodes.size(); ++i)
    if (std::abs((side.position(i) - side.point).dot(side.normal)) > flat_tolerance * side.shortest_edge_m)
      return false;
  return std::all_of(side.faces().begin(), side.faces().end(), [&](const fem::Face& face) {
    return fem::face_normal(side.body->mesh, face).dot(side.normal) >= 1.0 - flat_tolerance;
  });
}

/// Area of a face.
double whole_area(const ContactSide& side, const fem::Face& face) {
  const fem::FaceArea nodal = fem::face_area(side.body->section, side.body->mesh, face);
  return std::accumulate(nodal.begin(), nodal.end(), 0.0);
}

/// On a curved surface the mean of its faces' normals; about an axis what is across it cancels. `of_all_ways`: see
/// make_side.
Eigen::Vector3d mean_normal(const ContactContext& context, const ContactSide& side, const std::vector<double>& given,
                            const std::optional<Eigen::Vector3d>& of_all_ways) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const fem::Face& face : side.faces()) {
    sum += whole_area(side, face) * fem::face_normal(side.body->mesh, face);
    area += whole_area(side, face);
  }
  if (context.scene.model == Model::axisymmetric) sum[0] = 0.0;
  if (!given.empty()) {
    const Eigen::Vector3d normal = in_space(given);
    if (normal.dot(sum) > -least_one_sided * area) return normal;
    context.refuse(fmt::format("a normal into surface \"{}\"", side.name), "one out of it");
  }
  if (sum.norm() > least_one_sided * area) return sum.normalized();
  if (of_all_ways) return *of_all_ways;
  context.refuse(fmt::format("surface \"{}\", which faces all ways", side.name),
                 "the part of it that may touch, as a surface of its own, or a normal towards the other surface");
}

void take_faces(const std::vector<fem::Face>& faces, ContactSide& side) {
  const fem::Mesh& mesh = side.body->mesh;
  std::vector<double> area(mesh.position.size(), 0.0);
  for (const fem::Face& face : faces) {
    const fem::FaceArea nodal = fem::face_area(side.body->section, mesh, face);
    for (std::size_t i = 0; i < face.size(); ++i) area[at(face[i])] += nodal[i];
    side.shortest_edge_m = std::min(side.shortest_edge_m, shortest_side(mesh, face));
  }
  for (const int node : side.nodes) side.area_m2.push_back(area[at(node)]);
}

}  // namespace

void ContactContext::refuse(const std::string& found, const std::string& allowed) const {
  throw ConfigError(fmt::format("{}: found {}; allowed: {}", scene.where(key("surfaces")), found, allowed));
}

ContactSide make_side(const ContactContext& context, const std::vector<BodyProblem>& bodies, const SurfaceName& name,
                      const std::vector<double>& normal, const std::optional<Eigen::Vector3d>& of_all_ways) {
  const Model model = context.scene.model;
  ContactSide side;
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
  const auto& refined = mesh.refined_surfaces;
  const bool is_refined = std::find(refined.begin(), refined.end(), name.surface) != refined.end();
  if (is_refined && !is_flat(side))
    context.refuse(
        fmt::format("surface \"{}\", which is curved and has elements that mesh.refine divides", side.name),
        "boxes away from it: the new nodes lie on the straight edges of the larger elements, not on a curve");
  const auto hangs = [&](int node) { return fem::hanging_at(mesh, node) != nullptr; };
  if (needs_pairs(context.scene) && std::any_of(side.nodes.begin(), side.nodes.end(), hangs))
    context.refuse(fmt::format("surface \"{}\" with nodes that hang, by mesh.refine, a tie or rigid = true", side.name),
                   "a surface of one size of elements of a body that deforms with massless contact or impact_update = "
                   "\"impedance\"");
  if (context.scene.contact_law().impact_update == ImpactUpdate::impedance && fem::materials_of(*side.body).size() > 1)
    context.refuse(fmt::format("surface \"{}\" of a body of several materials", side.name),
                   "bodies of one material with impact_update = \"impedance\"");
  if (model == Model::bar || (is_flat(side) && !with_placed_plane(context.contact))) return side;
  side.flat = false;
  side.normal = mean_normal(context, side, normal, of_all_ways);
  for (std::size_t i = 0; i < side.nodes.size(); ++i)
    if (side.position(i).dot(side.normal) > side.point.dot(side.normal)) side.point = side.position(i);
  return side;
}

bool with_placed_plane(const Contact& contact) {
  return !contact.second && contact.obstacle == Obstacle::plane && !contact.rigid_place_m.empty();
}

std::string place_on(const ContactSide& side, const Eigen::Vector3d& x) {
  if (side.body->section.model == Model::solid) return fmt::format("({:.9g}, {:.9g}, {:.9g}) m", x[0], x[1], x[2]);
  return fmt::format("({:.9g}, {:.9g}) m", x[0], x[1]);
}

double initial_motion(const ContactSide& side, int node, const Eigen::Vector3d& normal) {
  const int components = fem::components(side.body->section.model);
  double u = 0.0;
  for (int c = 0; c < components; ++c) u += normal[c] * side.body->initial_displacement_m[node * components + c];
  return u;
}

bool held_along(const ContactSide& side, int node, const Eigen::Vector3d& normal) {
  const int components = fem::components(side.body->section.model);
  bool held = true;
  for (int c = 0; c < components; ++c)
    if (std::abs(normal[c]) > flat_tolerance) held = held && side.body->fixed_dof[at(node * components + c)];
  return held;
}

Eigen::Vector3d in_space(const std::vector<double>& x) {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < x.size(); ++c) v[static_cast<Eigen::Index>(c)] = x[c];
  return v;
}

Eigen::Vector3d closing_velocity(const Scene& scene, const ContactSide& a, const ContactSide* b) {
  const Eigen::Vector3d first = in_space(scene.body(a.body->name).initial_velocity_m_s);
  return b == nullptr ? Eigen::Vector3d(-first) : in_space(scene.body(b->body->name).initial_velocity_m_s) - first;
}

bool may_slide(const Scene& scene, const ContactSide& a, const ContactSide* b, const Eigen::Vector3d& normal) {
  if (scene.body(a.body->name).large_rotation || (b != nullptr && scene.body(b->body->name).large_rotation))
    return true;
  const auto along = [&](const Eigen::Vector3d& x) {
    return (x - x.dot(normal) * normal).norm() > direction_tolerance * x.norm();
  };
  const auto driven = [&](const Body& body) {
    const auto pulled = [&](const Traction& traction) {
      return traction.pressure_pa != 0.0 || along(in_space(traction.traction_pa));
    };
    const auto moved = [&](const PrescribedMotion& p) {
      return p.turn.has_value() || along(Eigen::Vector3d::Unit(p.component));
    };
    return along(in_space(body.gravity_m_s2)) || std::any_of(body.tractions.begin(), body.tractions.end(), pulled) ||
           std::any_of(body.prescribed.begin(), body.prescribed.end(), moved);
  };
  return along(closing_velocity(scene, a, b)) || driven(scene.body(a.body->name)) ||
         (b != nullptr && driven(scene.body(b->body->name)));
}

}  // namespace ricochet::scene
