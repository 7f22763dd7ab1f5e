#include <fmt/format.h>

#include <Eigen/Geometry>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
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

fem::Mesh mesh_of_file(const Scene& scene, const GmshMesh& spec, const std::string& body) {
  fem::Mesh mesh = fem::is_inp_file(spec.path) ? fem::read_inp(spec.path, scene.model, body, scene.bodies.size() == 1)
                                               : fem::read_gmsh(spec.path, scene.model, body);
  for (Eigen::Vector3d& position : mesh.position) position *= spec.unit_m;
  return mesh;
}

void refine(const Scene& scene, const Body& body, fem::Mesh& mesh) {
  for (std::size_t i = 0; i < body.refine.size(); ++i) {
    fem::RefinedBox box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), body.refine[i].ratio};
    for (std::size_t c = 0; c < at(scene.components()); ++c) {
      box.from_m[static_cast<Eigen::Index>(c)] = body.refine[i].from_m[c];
      box.to_m[static_cast<Eigen::Index>(c)] = body.refine[i].to_m[c];
    }
    try {
      fem::refine(mesh, box);
    } catch (const ConfigError& error) {
      throw ConfigError(
          fmt::format("{}: {}", scene.where(fmt::format("body.{}.mesh.refine[{}]", body.name, i)), error.what()));
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
    const auto* file = std::get_if<GmshMesh>(&body.mesh);
    if (file != nullptr && fem::is_inp_file(file->path) && fem::inp_has_node_set(file->path, surface))
      return fmt::format("; {} has a *NSET of that name, whose nodes have no faces: write *SURFACE, NAME={} there",
                         file->path, surface);
  }
  return "";
}

}  // namespace

fem::Mesh build_mesh(const Scene& scene, const Body& body) {
  const std::string key = "body." + body.name + ".mesh";
  fem::Mesh mesh;
  try {
    const auto* file = std::get_if<GmshMesh>(&body.mesh);
    mesh = file == nullptr ? structured_mesh(scene.model, std::get<StructuredMesh>(body.mesh))
                           : mesh_of_file(scene, *file, body.name);
    fem::check_mesh(mesh, body.name);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", scene.where(key), error.what()));
  }
  refine(scene, body, mesh);
  put_in_place(body.place, mesh);
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
