#include "common/fem/part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/base/error.hpp"

namespace ricochet::fem {
namespace {

/// Local nodes in ascending body-node order, the elements renumbered.
void take_elements(const Mesh& whole, const std::vector<int>& extra_nodes, Part& part) {
  std::set<int> nodes(extra_nodes.begin(), extra_nodes.end());
  for (const int e : part.body_element) {
    nodes.insert(whole.elements[at(e)].begin(), whole.elements[at(e)].end());
  }
  part.body_node.assign(nodes.begin(), nodes.end());
  std::vector<int> local(whole.position.size(), -1);
  for (std::size_t i = 0; i < part.body_node.size(); ++i) {
    local[at(part.body_node[i])] = static_cast<int>(i);
    part.mesh.position.push_back(whole.position[at(part.body_node[i])]);
  }
  for (const int e : part.body_element) {
    Element& element = part.mesh.elements.emplace_back(whole.elements[at(e)]);
    for (int& node : element) node = local[at(node)];
  }
}

int local_index(const std::vector<int>& ascending, int whole_index) {
  const auto found = std::lower_bound(ascending.begin(), ascending.end(), whole_index);
  if (found == ascending.end() || *found != whole_index) return -1;
  return static_cast<int>(found - ascending.begin());
}

/// Faces of the elements: directed edges, or the nodes of bars, doubled. An edge inside the body belongs, in the
/// direction in which the body lies to the left, to one element only, so a surface's loads are never taken by two
/// parts.
std::set<std::array<int, 2>> faces(const Mesh& mesh) {
  std::set<std::array<int, 2>> faces;
  for (const auto& element : mesh.elements) {
    for (const auto& [a, b] : traits(element.kind).faces) faces.insert({element[at(a)], element[at(b)]});
  }
  return faces;
}

void take_groups_and_surfaces(const Mesh& whole, Part& part) {
  for (const auto& [name, elements] : whole.element_groups) {
    auto& group = part.mesh.element_groups[name];
    for (const int e : elements) {
      if (const int i = local_index(part.body_element, e); i >= 0) group.push_back(i);
    }
  }
  const auto own = faces(part.mesh);
  for (const auto& [name, edges] : whole.surfaces) {
    auto& surface = part.mesh.surfaces[name];
    for (const auto& [a, b] : edges) {
      const std::array<int, 2> edge = {local_index(part.body_node, a), local_index(part.body_node, b)};
      if (own.contains(edge)) surface.push_back(edge);
    }
  }
}

/// Element by element in ascending order, every entry of an element kept even if zero: the structure is symmetric and
/// the sums depend on nothing but the elements.
void assemble(Part& part) {
  const int dofs_per_node = components(part.mesh.model);
  part.lumped_mass = Eigen::VectorXd::Zero(part.nodes());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(part.mesh.elements.size() * 64);
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const auto& nodes = part.mesh.elements[at(e)];
    const ElementGeometry geometry = element_geometry(part.mesh, e);
    const ElementMatrix stiffness = element_stiffness(part.section, part.material, geometry);
    const Eigen::VectorXd mass = element_lumped_mass(part.section, part.material, geometry);
    const auto dof = [&](int i) { return nodes[at(i / dofs_per_node)] * dofs_per_node + i % dofs_per_node; };
    for (int i = 0; i < mass.size(); ++i) part.lumped_mass[nodes[at(i)]] += mass[i];
    for (int i = 0; i < stiffness.rows(); ++i) {
      for (int j = 0; j < stiffness.cols(); ++j) entries.emplace_back(dof(i), dof(j), stiffness(i, j));
    }
  }
  part.stiffness.resize(part.dofs(), part.dofs());
  part.stiffness.setFromTriplets(entries.begin(), entries.end());
  part.stiffness.makeCompressed();
}

}  // namespace

Part extract_part(const Mesh& whole, const std::string& body, const Section& section, const Material& material,
                  const std::vector<int>& elements, const std::vector<int>& extra_nodes) {
  Part part;
  part.body = body;
  part.section = section;
  part.material = material;
  part.mesh.model = whole.model;
  part.mesh.period_m = whole.period_m;
  part.body_element = elements;
  std::sort(part.body_element.begin(), part.body_element.end());
  take_elements(whole, extra_nodes, part);
  take_groups_and_surfaces(whole, part);
  assemble(part);
  return part;
}

ElementGeometry element_geometry(const Mesh& mesh, int element) {
  const Element& nodes = mesh.elements[at(element)];
  ElementGeometry geometry{nodes.kind, ElementCoordinates(nodes.size(), 2)};
  const Eigen::Vector2d& first = mesh.position[at(nodes[0])];
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    geometry.x.row(static_cast<Eigen::Index>(i)) = nearest_image(mesh, mesh.position[at(nodes[i])], first).transpose();
  }
  return geometry;
}

ElementVector element_displacement(const Mesh& mesh, int element, const Eigen::VectorXd& u) {
  const Element& nodes = mesh.elements[at(element)];
  const int dofs_per_node = components(mesh.model);
  ElementVector values(static_cast<Eigen::Index>(nodes.size()) * dofs_per_node);
  Eigen::Index next = 0;
  for (const int node : nodes) {
    values.segment(next, dofs_per_node) = u.segment(node * dofs_per_node, dofs_per_node);
    next += dofs_per_node;
  }
  return values;
}

double element_critical_time_step(const Part& part) {
  double largest = 0.0;
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const ElementGeometry geometry = element_geometry(part.mesh, e);
    largest = std::max(largest, element_max_frequency_squared(part.section, part.material, geometry));
  }
  return largest > 0.0 ? 2.0 / std::sqrt(largest) : std::numeric_limits<double>::infinity();
}

Eigen::VectorXd traction_force(const Part& part, const std::string& surface, const std::vector<double>& traction_pa) {
  const int dofs_per_node = components(part.mesh.model);
  (void)surface_nodes(part.mesh, surface);  // refuses an unknown surface by name
  Eigen::VectorXd force = Eigen::VectorXd::Zero(part.dofs());
  for (const auto& edge : part.mesh.surfaces.at(surface)) {
    const Eigen::Vector2d& first = part.mesh.position[at(edge[0])];
    const Eigen::Vector2d second = nearest_image(part.mesh, part.mesh.position[at(edge[1])], first);
    const Eigen::Vector2d area = edge_area(part.section, first, second);
    for (int end = 0; end < 2; ++end) {
      for (int c = 0; c < dofs_per_node; ++c) {
        force[edge[at(end)] * dofs_per_node + c] += area[end] * traction_pa[at(c)];
      }
    }
  }
  return force;
}

Eigen::VectorXd gravity_force(const Part& part, const std::vector<double>& gravity_m_s2) {
  const int dofs_per_node = components(part.mesh.model);
  Eigen::VectorXd force(part.dofs());
  for (int i = 0; i < part.dofs(); ++i) {
    force[i] = part.lumped_mass[i / dofs_per_node] * gravity_m_s2[at(i % dofs_per_node)];
  }
  return force;
}

}  // namespace ricochet::fem
