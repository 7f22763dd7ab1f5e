#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/fem/boundary.hpp"
#include "common/fem/inp_file.hpp"
#include "common/fem/refine.hpp"
#include "common/problem/build.hpp"
#include "common/scene/reader.hpp"

namespace ricochet::scene {
namespace {

/// Makes the last column of nodes the first one of the next period, of a solid the last row of each layer, too. Nodes
/// are numbered row by row; `rows` elements wide, 0 in two dimensions, where there is one layer that does not repeat.
void wrap_across(fem::Mesh& mesh, int columns, int rows, double period_m) {
  const int layer = rows > 0 ? rows + 1 : static_cast<int>(mesh.position.size());
  const int kept_rows = rows > 0 ? rows : layer;
  const auto wrapped = [=](int node) {
    const int line = node / (columns + 1), column = node % (columns + 1);
    return (line / layer * kept_rows + line % layer % kept_rows) * columns + column % columns;
  };
  std::vector<Eigen::Vector3d> position;
  for (std::size_t i = 0; i < mesh.position.size(); ++i) {
    const int line = static_cast<int>(i) / (columns + 1), column = static_cast<int>(i) % (columns + 1);
    if (column != columns && line % layer != kept_rows) position.push_back(mesh.position[i]);
  }
  mesh.position = std::move(position);
  for (auto& element : mesh.elements)
    for (int& node : element) node = wrapped(node);
  for (const char* side : {"inner", "outer", "front", "back"}) mesh.surfaces.erase(side);
  for (auto& [name, faces] : mesh.surfaces)
    for (fem::Face& face : faces)
      for (int& node : face) node = wrapped(node);
  mesh.period_m = period_m;
}

fem::Mesh structured_mesh(Model model, const StructuredMesh& spec) {
  const std::vector<double> along =
      fem::graded_coordinates(spec.start_m, spec.length_m, spec.elements_along, spec.grading_along);
  if (model == Model::bar) return fem::bar_mesh(along);
  const std::vector<double> across =
      fem::graded_coordinates(0.0, spec.across_m, spec.elements_across, spec.grading_across);
  if (spec.cylinder) return fem::cylinder_mesh(across, along);
  const bool solid = model == Model::solid;
  fem::Mesh mesh =
      solid ? fem::block_mesh(across, fem::graded_coordinates(0.0, spec.width_m, spec.elements_wide, spec.grading_wide),
                              along)
            : fem::quadrilateral_mesh(model, across, along);
  if (!spec.periodic_across) return mesh;
  wrap_across(mesh, spec.elements_across, solid ? spec.elements_wide : 0, spec.across_m);
  if (solid) mesh.period_wide_m = spec.width_m;
  return mesh;
}

/// `only`: no other body or piece is there whose elements the file could hold.
fem::Mesh mesh_of_file(const Scene& scene, const GmshMesh& spec, const std::string& name, bool only) {
  fem::Mesh mesh = fem::is_inp_file(spec.path) ? fem::read_inp(spec.path, scene.model, name, only)
                                               : fem::read_gmsh(spec.path, scene.model, name);
  for (Eigen::Vector3d& position : mesh.position) position *= spec.unit_m;
  return mesh;
}

void refine(const Scene& scene, const std::string& key, const MeshPiece& piece, fem::Mesh& mesh) {
  for (std::size_t i = 0; i < piece.refine.size(); ++i) {
    fem::RefinedBox box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), piece.refine[i].ratio};
    for (std::size_t c = 0; c < at(scene.components()); ++c) {
      box.from_m[static_cast<Eigen::Index>(c)] = piece.refine[i].from_m[c];
      box.to_m[static_cast<Eigen::Index>(c)] = piece.refine[i].to_m[c];
    }
    try {
      fem::refine(mesh, box);
    } catch (const ConfigError& error) {
      throw ConfigError(fmt::format("{}: {}", scene.where(fmt::format("{}.refine[{}]", key, i)), error.what()));
    }
  }
}

/// Exactly where it was if it is neither turned nor moved.
void put_in_place(const MeshPlace& place, fem::Mesh& mesh) {
  const auto vector = [](const std::array<double, 3>& v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
  const Eigen::Vector3d turned = vector(place.turned_rad), about = vector(place.about_m), moved = vector(place.moved_m);
  const double angle = turned.norm();
  const Eigen::Matrix3d rotation =
      angle > 0.0 ? Eigen::AngleAxisd(angle, turned / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
  for (Eigen::Vector3d& x : mesh.position) {
    if (angle > 0.0) x = about + rotation * (x - about);
    x += moved;
  }
}

/// A set of nodes has no faces, without which there is neither an area nor a normal.
std::string node_set_text(const Scene& scene, const std::string& surface) {
  for (const Body& body : scene.bodies) {
    for (const GmshMesh* file : body.files())
      if (fem::is_inp_file(file->path) && fem::inp_has_node_set(file->path, surface))
        return fmt::format("; {} has a *NSET of that name, whose nodes have no faces: write *SURFACE, NAME={} there",
                           file->path, surface);
  }
  return "";
}

fem::Mesh piece_mesh(const Scene& scene, const Body& body, const MeshPiece& piece) {
  const std::string key =
      fmt::format("body.{}.mesh{}", body.name, body.of_pieces() ? ".piece." + piece.name : std::string());
  fem::Mesh mesh;
  try {
    const auto* file = std::get_if<GmshMesh>(&piece.elements);
    mesh = file == nullptr ? structured_mesh(scene.model, std::get<StructuredMesh>(piece.elements))
                           : mesh_of_file(scene, *file, body.of_pieces() ? piece.name : body.name,
                                          scene.bodies.size() == 1 && !body.of_pieces());
    fem::check_mesh(mesh, body.name);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", scene.where(key), error.what()));
  }
  if (has_outside(body) && !mesh.surfaces.contains(outside_surface)) {
    for (const auto& [face, element] : fem::boundary_faces(mesh)) mesh.surfaces[outside_surface].push_back(face);
  }
  refine(scene, key, piece, mesh);
  put_in_place(piece.place, mesh);
  return mesh;
}

/// Groups and surfaces are "PIECE.NAME"; the group "PIECE" has all elements of a piece.
void append(const fem::Mesh& piece, const std::string& name, fem::Mesh& mesh) {
  const auto nodes = static_cast<int>(mesh.position.size()), elements = static_cast<int>(mesh.elements.size());
  mesh.model = piece.model;
  mesh.position.insert(mesh.position.end(), piece.position.begin(), piece.position.end());
  for (fem::Element element : piece.elements) {
    for (int& node : element) node += nodes;
    mesh.element_groups[name].push_back(static_cast<int>(mesh.elements.size()));
    mesh.elements.push_back(element);
  }
  for (const auto& [group, members] : piece.element_groups)
    for (const int element : members) mesh.element_groups[name + "." + group].push_back(elements + element);
  for (const auto& [surface, faces] : piece.surfaces) {
    for (fem::Face face : faces) {
      for (int& node : face) node += nodes;
      mesh.surfaces[name + "." + surface].push_back(face);
    }
  }
  for (fem::HangingNode hanging : piece.hanging) {
    hanging.node += nodes;
    for (auto& carrier : hanging.carriers) carrier.node += nodes;
    mesh.hanging.push_back(std::move(hanging));
  }
  for (const std::string& surface : piece.refined_surfaces) mesh.refined_surfaces.push_back(name + "." + surface);
}

/// A group's material goes before that of a piece.
void set_materials(const Scene& scene, const Body& body, fem::Mesh& mesh) {
  const auto has_own = [](const MeshPiece& piece) { return piece.material.has_value(); };
  if (body.groups.empty() && std::none_of(body.pieces.begin(), body.pieces.end(), has_own)) return;
  mesh.material.assign(mesh.elements.size(), -1);
  for (const MeshPiece& piece : body.pieces) {
    if (!piece.material) continue;
    for (const int element : mesh.element_groups.at(piece.name))
      mesh.material[at(element)] = static_cast<int>(mesh.materials.size());
    mesh.materials.push_back(*piece.material);
  }
  const auto first = static_cast<int>(mesh.materials.size());
  std::vector<std::string> known;
  for (const auto& group : mesh.element_groups) known.push_back(group.first);
  for (const GroupMaterial& of : body.groups) {
    const auto refuse = [&](const std::string& found, const std::string& allowed) {
      throw ConfigError(fmt::format("{}: found {}; allowed: {}",
                                    scene.where("body." + body.name + ".group." + of.group), found, allowed));
    };
    const auto group = mesh.element_groups.find(of.group);
    if (group == mesh.element_groups.end())
      refuse(fmt::format("group \"{}\"{}", of.group, did_you_mean(of.group, known)),
             known.empty() ? "none, the mesh has no group of elements" : one_of(known));
    for (const int element : group->second) {
      int& material = mesh.material[at(element)];
      if (material >= first)
        refuse(fmt::format("an element of group \"{}\", too", body.groups[at(material - first)].group),
               "groups that share no element");
      material = static_cast<int>(mesh.materials.size());
    }
    mesh.materials.push_back(of.material);
  }
}

}  // namespace

fem::Mesh build_mesh(const Scene& scene, const Body& body) {
  fem::Mesh mesh;
  if (!body.of_pieces()) mesh = piece_mesh(scene, body, body.pieces.front());
  for (const MeshPiece& piece : body.pieces)
    if (body.of_pieces()) append(piece_mesh(scene, body, piece), piece.name, mesh);
  if (mesh.elements.size() > fem::most_elements)
    throw ConfigError(fmt::format("{}: found {} elements in all pieces; allowed: at most {} in a body",
                                  scene.where("body." + body.name + ".mesh"), mesh.elements.size(),
                                  fem::most_elements));
  set_materials(scene, body, mesh);
  tie_pieces(scene, body, mesh);
  return mesh;
}

void require_surface(const Scene& scene, const std::string& key, const fem::Mesh& mesh, const std::string& surface) {
  if (mesh.surfaces.count(surface) > 0) return;
  std::vector<std::string> known;
  for (const auto& entry : mesh.surfaces) known.push_back(entry.first);
  throw ConfigError(
      fmt::format("{}: found surface \"{}\"{}; allowed: {}{}", scene.where(key), surface, did_you_mean(surface, known),
                  known.empty() ? "none, the mesh has no surface" : one_of(known), node_set_text(scene, surface)));
}

}  // namespace ricochet::scene
