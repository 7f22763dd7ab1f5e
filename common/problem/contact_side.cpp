#include "common/problem/contact_side.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "common/base/error.hpp"

namespace ricochet::scene {
namespace {

/// A surface whose normals cancel to this share of its area faces no one way.
constexpr double least_one_sided = 0.1;
/// What lies along a surface to this share of its size does so by rounding.
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

/// Of a curved surface the mean of its faces' normals; about an axis what is across it cancels.
Eigen::Vector3d mean_normal(const ContactContext& context, const ContactSide& side, const std::vector<double>& given) {
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
                      const std::vector<double>& normal) {
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
  if (model == Model::bar || is_flat(side)) return side;
  side.flat = false;
  side.normal = mean_normal(context, side, normal);
  for (std::size_t i = 0; i < side.nodes.size(); ++i)
    if (side.position(i).dot(side.normal) > side.point.dot(side.normal)) side.point = side.position(i);
  return side;
}

std::string place_on(const ContactSide& side, const Eigen::Vector3d& x) {
  if (side.body->section.model == Model::solid) return fmt::format("({:.9g}, {:.9g}, {:.9g}) m", x[0], x[1], x[2]);
  return fmt::format("({:.9g}, {:.9g}) m", x[0], x[1]);
}

namespace {

/// Of a face: a node of an edge, two of what bounds others.
using Rim = std::vector<int>;

std::vector<Rim> rims_of(const SurfaceFace& face) {
  std::vector<Rim> rims;
  const std::size_t corners = face.node.size();
  for (std::size_t i = 0; i < corners; ++i)
    rims.push_back(corners == 2 ? Rim{face.node[i]}
                                : Rim{std::min(face.node[i], face.node[(i + 1) % corners]),
                                      std::max(face.node[i], face.node[(i + 1) % corners])});
  return rims;
}

/// Faces that meet, one after the other, without an edge between them are one piece.
void set_patches(std::vector<SurfaceFace>& faces) {
  std::map<Rim, std::vector<std::size_t>> at_rim;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    faces[i].patch = -1;
    for (const Rim& rim : rims_of(faces[i])) at_rim[rim].push_back(i);
  }
  const double least = std::cos(patch_angle) - flat_tolerance;
  int patch = 0;
  for (std::size_t first = 0; first < faces.size(); ++first) {
    if (faces[first].patch >= 0) continue;
    std::vector<std::size_t> open{first};
    faces[first].patch = patch;
    while (!open.empty()) {
      const SurfaceFace face = faces[open.back()];
      open.pop_back();
      for (const Rim& rim : rims_of(face)) {
        for (const std::size_t next : at_rim[rim]) {
          if (faces[next].patch >= 0 || faces[next].normal.dot(face.normal) < least) continue;
          faces[next].patch = patch;
          open.push_back(next);
        }
      }
    }
    ++patch;
  }
}

/// A node of a piece of a surface, while its normal is sought.
struct PatchNode {
  Eigen::Vector3d sum{0.0, 0.0, 0.0}, mirrored{0.0, 0.0, 0.0};
  unsigned held = 0;  ///< SurfaceFace::held
  bool at_rim = false;
};
using PatchNodes = std::map<std::pair<int, int>, PatchNode>;

Eigen::Vector3d without(unsigned held, Eigen::Vector3d normal) {
  for (Eigen::Index c = 0; c < 3; ++c)
    if ((held >> c & 1U) != 0) normal[c] = 0.0;
  return normal;
}

/// What a corner adds to the sum of its node: a face's normal over the length of an edge; of a triangle or
/// quadrilateral e x f/(|e|^2 |f|^2), its edges there.
Eigen::Vector3d share_of(const SurfaceFace& face, std::size_t corner) {
  const std::size_t corners = face.node.size();
  const Eigen::Vector3d to = face.x[(corner + 1) % corners] - face.x[corner],
                        from = face.x[(corner + corners - 1) % corners] - face.x[corner];
  return corners == 2 ? Eigen::Vector3d(face.normal / to.norm())
                      : Eigen::Vector3d(to.cross(from) / (to.squaredNorm() * from.squaredNorm()));
}

/// Where a plane of symmetry holds it, a surface goes on beyond.
void find_rims(const std::vector<SurfaceFace>& faces, PatchNodes& nodes) {
  std::map<std::pair<int, Rim>, int> count;
  for (const SurfaceFace& face : faces)
    for (const Rim& rim : rims_of(face)) ++count[{face.patch, rim}];
  for (const auto& [rim, faces_there] : count) {
    unsigned held = ~0U;
    for (const int node : rim.second) held &= nodes.at({rim.first, node}).held;
    for (const int node : rim.second)
      if (faces_there == 1 && held == 0) nodes.at({rim.first, node}).at_rim = true;
  }
}

/// At the rim there are faces on one side alone: there the normal is that of a node inside, mirrored by the edge
/// between the two, as on a circle.
void mirror_inwards(const std::vector<SurfaceFace>& faces, PatchNodes& nodes) {
  for (const SurfaceFace& face : faces) {
    const std::size_t corners = face.node.size();
    for (std::size_t i = 0; i < corners; ++i) {
      for (const std::size_t other : {(i + 1) % corners, (i + corners - 1) % corners}) {
        PatchNode& node = nodes.at({face.patch, face.node[i]});
        const PatchNode& inside = nodes.at({face.patch, face.node[other]});
        if (!node.at_rim || inside.at_rim) continue;
        const Eigen::Vector3d along = (face.x[other] - face.x[i]).normalized(), normal = inside.sum.normalized();
        node.mirrored += normal - 2.0 * normal.dot(along) * along;
      }
    }
  }
}

/// Bits of the coordinates along which supports hold a node of a curved surface, but not if that is all its normal has.
unsigned held_at(const ContactSide& side, int node, const Eigen::Vector3d& normal) {
  const int components = fem::components(side.body->section.model);
  unsigned held = 0;
  Eigen::Vector3d free = normal;
  for (int c = 0; c < components; ++c) {
    if (!side.body->fixed_dof[at(node * components + c)]) continue;
    free[c] = 0.0;
    held |= 1U << c;
  }
  return free.isZero(0.0) ? 0 : held;
}

void set_normals(const ContactSide& side, std::vector<SurfaceFace>& faces) {
  PatchNodes nodes;
  for (const SurfaceFace& face : faces) {
    for (std::size_t i = 0; i < face.node.size(); ++i) nodes[{face.patch, face.node[i]}].sum += share_of(face, i);
  }
  for (auto& [place, node] : nodes) {
    node.held = held_at(side, place.second, node.sum);
    node.sum = without(node.held, node.sum);
  }
  find_rims(faces, nodes);
  mirror_inwards(faces, nodes);
  for (SurfaceFace& face : faces) {
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      const PatchNode& node = nodes.at({face.patch, face.node[i]});
      face.held[i] = side.flat ? 0 : node.held;
      const Eigen::Vector3d normal = without(node.held, node.mirrored.isZero(0.0) ? node.sum : node.mirrored);
      face.node_normal[i] = side.flat ? side.normal : normal.normalized();
    }
  }
}

}  // namespace

std::vector<SurfaceFace> faces_of(const ContactSide& side) {
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
  set_patches(faces);
  set_normals(side, faces);
  return faces;
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

bool may_slide(const Scene& scene, const ContactSide& a, const ContactSide* b, const Eigen::Vector3d& normal) {
  const auto vector = [](const std::vector<double>& x) {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < x.size(); ++c) v[static_cast<Eigen::Index>(c)] = x[c];
    return v;
  };
  const auto along = [&](const Eigen::Vector3d& x) {
    return (x - x.dot(normal) * normal).norm() > direction_tolerance * x.norm();
  };
  const auto driven = [&](const Body& body) {
    const auto pulled = [&](const Traction& traction) { return along(vector(traction.traction_pa)); };
    const auto moved = [&](const PrescribedDisplacement& p) { return along(Eigen::Vector3d::Unit(p.component)); };
    return along(vector(body.gravity_m_s2)) || std::any_of(body.tractions.begin(), body.tractions.end(), pulled) ||
           std::any_of(body.prescribed.begin(), body.prescribed.end(), moved);
  };
  Eigen::Vector3d closing = vector(scene.body(a.body->name).initial_velocity_m_s);
  if (b != nullptr) closing -= vector(scene.body(b->body->name).initial_velocity_m_s);
  return along(closing) || driven(scene.body(a.body->name)) || (b != nullptr && driven(scene.body(b->body->name)));
}

}  // namespace ricochet::scene
