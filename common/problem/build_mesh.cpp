#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/problem/build.hpp"
#include "common/scene/reader.hpp"

namespace ricochet::scene {
namespace {

/// Makes the last column of nodes the first one of the next period. Nodes are numbered row by row.
void wrap_across(fem::Mesh& mesh, int columns, double period_m) {
  const auto wrapped = [columns](int node) {
    const int row = node / (columns + 1), column = node % (columns + 1);
    return row * columns + column % columns;
  };
  std::vector<Eigen::Vector3d> position;
  for (std::size_t i = 0; i < mesh.position.size(); ++i)
    if (static_cast<int>(i) % (columns + 1) != columns) position.push_back(mesh.position[i]);
  mesh.position = std::move(position);
  for (auto& element : mesh.elements)
    for (int& node : element) node = wrapped(node);
  mesh.surfaces.erase("inner");
  mesh.surfaces.erase("outer");
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
  if (model == Model::solid)
    return fem::block_mesh(across, fem::graded_coordinates(0.0, spec.width_m, spec.elements_wide, spec.grading_wide),
                           along);
  fem::Mesh mesh = fem::quadrilateral_mesh(model, across, along);
  if (spec.periodic_across) wrap_across(mesh, spec.elements_across, spec.across_m);
  return mesh;
}

}  // namespace

fem::Mesh build_mesh(const Scene& scene, const Body& body) {
  const std::string key = "body." + body.name + ".mesh";
  try {
    fem::Mesh mesh = std::holds_alternative<StructuredMesh>(body.mesh)
                         ? structured_mesh(scene.model, std::get<StructuredMesh>(body.mesh))
                         : fem::read_gmsh(std::get<GmshMesh>(body.mesh).path, scene.model, body.name);
    fem::check_mesh(mesh, body.name);
    return mesh;
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", scene.where(key), error.what()));
  }
}

void require_surface(const Scene& scene, const std::string& key, const fem::Mesh& mesh, const std::string& surface) {
  if (mesh.surfaces.count(surface) > 0) return;
  std::vector<std::string> known;
  for (const auto& entry : mesh.surfaces) known.push_back(entry.first);
  throw ConfigError(fmt::format("{}: found surface \"{}\"{}; allowed: {}", scene.where(key), surface,
                                did_you_mean(surface, known), one_of(known)));
}

}  // namespace ricochet::scene
