#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "common/fem/part.hpp"

/// Meshes and materials that several tests use.
namespace ricochet::fem::sample {

inline const Material steel{210e9, 0.3, 7850.0};
inline const std::vector<Model> every_model = {Model::bar, Model::plane_strain, Model::axisymmetric, Model::solid};

inline Section section(Model model) {
  if (model == Model::bar) return {model, 2.5e-4};
  if (model == Model::solid) return {model, 1.0};
  return {model, model == Model::plane_strain ? 0.03 : 2.0 * std::numbers::pi};
}

inline std::string name(Model model) {
  if (model == Model::bar) return "bar";
  if (model == Model::solid) return "solid";
  return model == Model::plane_strain ? "plane_strain" : "axisymmetric";
}

/// A 3 x 3 x 4 mesh of [0, 0.03] x [0, 0.02] x [0.01, 0.05] m whose inner nodes are moved off the grid.
inline Mesh distorted_block() {
  Mesh mesh = block_mesh(graded_coordinates(0.0, 0.03, 3, 1.0), graded_coordinates(0.0, 0.02, 3, 1.0),
                         graded_coordinates(0.01, 0.04, 4, 1.0));
  const Eigen::Array3d low(0.0, 0.0, 0.01), high(0.03, 0.02, 0.05);
  for (std::size_t i = 0; i < mesh.position.size(); ++i) {
    Eigen::Vector3d& x = mesh.position[i];
    if ((x.array() < low + 1e-6).any() || (x.array() > high - 1e-6).any()) continue;
    const double phase = static_cast<double>(i);
    x += 1.5e-3 * Eigen::Vector3d(std::sin(3.0 * phase), std::cos(5.0 * phase), std::sin(7.0 * phase));
  }
  return mesh;
}

/// A 3 x 4 mesh of [0, 0.03] x [0.01, 0.05] m whose inner nodes are moved off the grid; a bar of uneven elements.
inline Mesh distorted_mesh(Model model) {
  if (model == Model::bar) return bar_mesh({0.0, 0.013, 0.02, 0.041, 0.05});
  if (model == Model::solid) return distorted_block();
  Mesh mesh = quadrilateral_mesh(model, graded_coordinates(0.0, 0.03, 3, 1.0), graded_coordinates(0.01, 0.04, 4, 1.0));
  for (std::size_t i = 0; i < mesh.position.size(); ++i) {
    Eigen::Vector3d& x = mesh.position[i];
    const bool inner = x[0] > 1e-6 && x[0] < 0.03 - 1e-6 && x[1] > 0.01 + 1e-6 && x[1] < 0.05 - 1e-6;
    if (!inner) continue;
    const double phase = static_cast<double>(i);
    x += 2.5e-3 * Eigen::Vector3d(std::sin(3.0 * phase), std::cos(5.0 * phase), 0.0);
  }
  return mesh;
}

/// The same mesh with every quadrilateral (`all`), or every second one, cut in two along a diagonal.
inline Mesh triangulated(const Mesh& whole, bool all = true) {
  Mesh mesh = whole;
  mesh.elements.clear();
  mesh.element_groups.clear();
  for (std::size_t e = 0; e < whole.elements.size(); ++e) {
    const Element& q = whole.elements[e];
    if (q.kind != ElementKind::quadrilateral || (!all && e % 2 == 0)) {
      mesh.elements.push_back(q);
      continue;
    }
    mesh.elements.push_back({ElementKind::triangle, {q[0], q[1], q[2]}});
    mesh.elements.push_back({ElementKind::triangle, {q[0], q[2], q[3]}});
  }
  return mesh;
}

/// The same with every hexahedron cut into six tetrahedra around its diagonal 0-6, its surfaces with their faces.
inline Mesh tetrahedra_of(const Mesh& whole) {
  Mesh mesh = whole;
  mesh.elements.clear();
  mesh.element_groups.clear();
  for (const Element& h : whole.elements) {
    constexpr int around[6] = {1, 2, 3, 7, 4, 5};
    for (std::size_t i = 0; i < 6; ++i) {
      mesh.elements.push_back({ElementKind::tetrahedron, {h[0], h[at(around[i])], h[at(around[(i + 1) % 6])], h[6]}});
    }
  }
  for (auto& [name, faces] : mesh.surfaces) faces.clear();
  for (const auto& [name, faces] : whole.surfaces) {
    std::vector<int> nodes;
    for (const Face& face : faces) nodes.insert(nodes.end(), face.begin(), face.end());
    for (const Element& element : mesh.elements) {
      for (Face face : traits(element.kind).faces) {
        for (int& node : face) node = element[at(node)];
        const auto on_it = [&](int node) { return std::find(nodes.begin(), nodes.end(), node) != nodes.end(); };
        if (std::all_of(face.begin(), face.end(), on_it)) mesh.surfaces[name].push_back(face);
      }
    }
  }
  return mesh;
}

inline std::vector<int> all_elements(const Mesh& mesh) {
  std::vector<int> elements(mesh.elements.size());
  std::iota(elements.begin(), elements.end(), 0);
  return elements;
}

inline Part whole_part(const Mesh& mesh, const Section& section_of_mesh, const Material& material = steel) {
  return extract_part(mesh, "body", section_of_mesh, material, all_elements(mesh));
}

inline Part distorted_part(Model model) { return whole_part(distorted_mesh(model), section(model)); }

/// |a - b| relative to |b|. (Vectors of changing size up to four make gcc 12 warn in Eigen's reductions.)
inline double relative_error(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return (a - b).norm() / b.norm(); }

/// Node-major values of a field at the nodes; it has as many components as the model, or more.
template <class Field>
Eigen::VectorXd nodal(const Mesh& mesh, const Field& field) {
  const int dofs_per_node = components(mesh.model);
  Eigen::VectorXd values(static_cast<Eigen::Index>(mesh.position.size()) * dofs_per_node);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto value = field(mesh.position[static_cast<std::size_t>(i / dofs_per_node)]);
    values[i] = value[i % dofs_per_node];
  }
  return values;
}

}  // namespace ricochet::fem::sample
