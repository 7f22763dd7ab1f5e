// The faces of a contact side: smooth pieces, and normals at their nodes.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "common/problem/contact_side.hpp"
#include "common/surface/box_tree.hpp"

namespace ricochet::scene {
namespace {

/// An edge is bounded by a node, other faces by two nodes a side.
using Rim = std::vector<int>;

std::vector<Rim> rims_of(const surface::SurfaceFace& face) {
  std::vector<Rim> rims;
  const std::size_t corners = face.node.size();
  for (std::size_t i = 0; i < corners; ++i)
    rims.push_back(corners == 2 ? Rim{face.node[i]}
                                : Rim{std::min(face.node[i], face.node[(i + 1) % corners]),
                                      std::max(face.node[i], face.node[(i + 1) % corners])});
  return rims;
}

/// Faces that meet, one after the other, without an edge between them are one piece.
void set_patches(std::vector<surface::SurfaceFace>& faces) {
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
      const surface::SurfaceFace face = faces[open.back()];
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

/// Share that a corner adds to the sum of its node: a face's normal over the length of an edge; of a triangle or
/// quadrilateral e x f/(|e|^2 |f|^2), its edges there.
Eigen::Vector3d share_of(const surface::SurfaceFace& face, std::size_t corner) {
  const std::size_t corners = face.node.size();
  const Eigen::Vector3d to = face.x[(corner + 1) % corners] - face.x[corner],
                        from = face.x[(corner + corners - 1) % corners] - face.x[corner];
  return corners == 2 ? Eigen::Vector3d(face.normal / to.norm())
                      : Eigen::Vector3d(to.cross(from) / (to.squaredNorm() * from.squaredNorm()));
}

/// Where a plane of symmetry holds it, a surface goes on beyond.
void find_rims(const std::vector<surface::SurfaceFace>& faces, PatchNodes& nodes) {
  std::map<std::pair<int, Rim>, int> count;
  for (const surface::SurfaceFace& face : faces)
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
void mirror_inwards(const std::vector<surface::SurfaceFace>& faces, PatchNodes& nodes) {
  for (const surface::SurfaceFace& face : faces) {
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
  if (side.body->turned_by[at(node)] >= 0) return 0;
  for (int c = 0; c < components; ++c) {
    if (!side.body->fixed_dof[at(node * components + c)]) continue;
    free[c] = 0.0;
    held |= 1U << c;
  }
  return free.isZero(0.0) ? 0 : held;
}

void set_normals(const ContactSide& side, std::vector<surface::SurfaceFace>& faces) {
  PatchNodes nodes;
  for (const surface::SurfaceFace& face : faces) {
    for (std::size_t i = 0; i < face.node.size(); ++i) nodes[{face.patch, face.node[i]}].sum += share_of(face, i);
  }
  for (auto& [place, node] : nodes) {
    node.held = held_at(side, place.second, node.sum);
    node.sum = without(node.held, node.sum);
  }
  find_rims(faces, nodes);
  mirror_inwards(faces, nodes);
  for (surface::SurfaceFace& face : faces) {
    for (std::size_t i = 0; i < face.node.size(); ++i) {
      const PatchNode& node = nodes.at({face.patch, face.node[i]});
      face.held[i] = side.flat ? 0 : node.held;
      face.sharp[i] = node.at_rim;
      const Eigen::Vector3d normal = without(node.held, node.mirrored.isZero(0.0) ? node.sum : node.mirrored);
      face.node_normal[i] = side.flat ? side.normal : normal.normalized();
    }
  }
}

Eigen::Vector3d middle_of(const surface::SurfaceFace& face) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < face.node.size(); ++i) sum += face.x[i];
  return sum / static_cast<double>(face.node.size());
}

/// Whether a line from a place along a direction, of which no component is 0, meets a box.
bool meets(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& place, const Eigen::Vector3d& along) {
  const Eigen::Array3d low = (box.min() - place).array() / along.array(),
                       high = (box.max() - place).array() / along.array();
  return low.max(high).minCoeff() >= std::max(0.0, low.min(high).maxCoeff());
}

/// Finds SurfaceFace::thickness_m where a surface goes around its body.
void set_thickness(std::vector<surface::SurfaceFace>& faces) {
  constexpr double least_facing = 0.1, beside = 1e-3;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const surface::SurfaceFace& face : faces) {
    Eigen::AlignedBox3d& box = boxes.emplace_back();
    for (std::size_t i = 0; i < face.node.size(); ++i) box.extend(face.x[i]);
    const Eigen::Vector3d wider = Eigen::Vector3d::Constant(1e-3 * box.diagonal().norm());
    box.min() -= wider;
    box.max() += wider;
  }
  const surface::BoxTree tree(boxes);
  for (surface::SurfaceFace& face : faces) {
    const Eigen::Vector3d place = middle_of(face), inwards = -face.normal;
    Eigen::Vector3d along = inwards;
    for (double& c : along) c = std::copysign(std::max(std::abs(c), 1e-12), c);
    tree.visit([&](const Eigen::AlignedBox3d& box) { return meets(box, place, along); },
               [&](std::size_t i) {
                 if (faces[i].normal.dot(inwards) < least_facing) return;
                 const surface::Hit hit = surface::hit_of(place, inwards, faces[i]);
                 if (hit.inside >= -beside && hit.far_m > 0.0) face.thickness_m = std::min(face.thickness_m, hit.far_m);
               });
  }
}

}  // namespace

std::vector<surface::SurfaceFace> faces_of(const ContactSide& side) {
  const fem::Mesh& mesh = side.body->mesh;
  const auto& section = side.body->section;
  std::vector<surface::SurfaceFace> faces;
  for (const fem::Face& nodes : side.faces()) {
    surface::SurfaceFace face{nodes, {}, {}, fem::face_normal(mesh, nodes)};
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      face.x[i] = fem::nearest_image(mesh, mesh.position[at(nodes[i])], mesh.position[at(nodes[0])]);
      face.measure[i] = section.measure * (section.model == Model::axisymmetric ? face.x[i][0] : 1.0);
    }
    faces.push_back(face);
  }
  set_patches(faces);
  set_normals(side, faces);
  if (!side.flat && mesh.period_m == 0.0) set_thickness(faces);
  return faces;
}

}  // namespace ricochet::scene
