#include "common/fem/part.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/element_copies.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/fem/neighbours.hpp"

namespace ricochet::fem {
namespace {

/// Local nodes in ascending body-node order, the elements renumbered.
void take_elements(const Mesh& whole, const std::vector<int>& extra_nodes, Part& part) {
  std::vector<int> local(whole.position.size(), -1);
  for (const int node : extra_nodes) local[at(node)] = 0;
  for (const int e : part.body_element) {
    for (const int node : whole.elements[at(e)]) local[at(node)] = 0;
    for_each_carrier(whole, whole.elements[at(e)], [&](int node) { local[at(node)] = 0; });
  }
  part.mesh.materials = whole.materials;
  for (const int e : whole.material.empty() ? std::vector<int>{} : part.body_element)
    part.mesh.material.push_back(whole.material[at(e)]);
  for (std::size_t node = 0; node < local.size(); ++node) {
    if (local[node] < 0) continue;
    local[node] = part.nodes();
    part.body_node.push_back(static_cast<int>(node));
    part.mesh.position.push_back(whole.position[node]);
  }
  part.mesh.elements.reserve(part.body_element.size());
  for (const int e : part.body_element) {
    Element& element = part.mesh.elements.emplace_back(whole.elements[at(e)]);
    for (int& node : element) node = local[at(node)];
  }
  const auto is_here = [&](const auto& nodes) {
    return std::all_of(nodes.begin(), nodes.end(), [&](const auto& of) { return local[at(of.node)] >= 0; });
  };
  for (const HangingNode& hanging : whole.hanging) {
    if (local[at(hanging.node)] < 0) continue;
    if (!is_here(hanging.carriers) || !is_here(hanging.between) || !is_here(hanging.beside)) continue;  // of no element
    HangingNode& own = part.mesh.hanging.emplace_back(hanging);
    own.node = local[at(hanging.node)];
    for (auto* of : {&own.carriers, &own.between, &own.beside})
      for (auto& carrier : *of) carrier.node = local[at(carrier.node)];
  }
}

int local_index(const std::vector<int>& ascending, int whole_index) {
  const auto found = std::lower_bound(ascending.begin(), ascending.end(), whole_index);
  if (found == ascending.end() || *found != whole_index) return -1;
  return static_cast<int>(found - ascending.begin());
}

/// Those of the faces, in local nodes, that elements of the part have. A face inside the body belongs, in the direction
/// that has the body behind it, to one element only, so a surface's loads are never taken by two parts.
std::set<Face> own_faces(const Mesh& mesh, const std::set<Face>& wanted) {
  std::vector<bool> has_wanted(mesh.position.size(), false);  // per node
  for (const Face& face : wanted) {
    for (const int node : face) has_wanted[at(node)] = true;
  }
  std::set<Face> own;
  for (const auto& element : mesh.elements) {
    for (Face face : traits(element.kind).faces) {
      for (int& node : face) node = element[at(node)];
      if (std::all_of(face.begin(), face.end(), [&](int node) { return has_wanted[at(node)]; }) &&
          wanted.contains(from_smallest(face)))
        own.insert(from_smallest(face));
    }
  }
  return own;
}

void take_groups_and_surfaces(const Mesh& whole, Part& part) {
  for (const auto& [name, elements] : whole.element_groups) {
    auto& group = part.mesh.element_groups[name];
    for (const int e : elements) {
      if (const int i = local_index(part.body_element, e); i >= 0) group.push_back(i);
    }
  }
  std::set<Face> wanted;
  for (const auto& [name, faces_of_whole] : whole.surfaces) {
    auto& surface = part.mesh.surfaces[name];
    for (Face face : faces_of_whole) {
      for (int& node : face) node = local_index(part.body_node, node);
      if (std::any_of(face.begin(), face.end(), [](int node) { return node < 0; })) continue;
      surface.push_back(face);
      wanted.insert(from_smallest(face));
    }
  }
  const auto own = own_faces(part.mesh, wanted);
  for (auto& [name, surface] : part.mesh.surfaces)
    std::erase_if(surface, [&](const Face& face) { return !own.contains(from_smallest(face)); });
}

/// A matrix of zeros with a block of entries for every two neighbours.
SparseMatrix zeros(const Neighbours& neighbours, int nodes, int dofs_per_node) {
  SparseMatrix matrix(nodes * dofs_per_node, nodes * dofs_per_node);
  matrix.resizeNonZeros(static_cast<Eigen::Index>(neighbours.node.size()) * dofs_per_node * dofs_per_node);
  int next = 0;
  for (int node = 0; node < nodes; ++node) {
    for (int r = 0; r < dofs_per_node; ++r) {
      matrix.outerIndexPtr()[node * dofs_per_node + r] = next;
      for (int k = neighbours.start[at(node)]; k < neighbours.start[at(node) + 1]; ++k) {
        for (int c = 0; c < dofs_per_node; ++c)
          matrix.innerIndexPtr()[next++] = neighbours.node[at(k)] * dofs_per_node + c;
      }
    }
  }
  matrix.outerIndexPtr()[nodes * dofs_per_node] = next;
  std::fill_n(matrix.valuePtr(), next, 0.0);
  return matrix;
}

/// Element by element in ascending order, every entry of an element kept even if zero: the structure is symmetric and
/// the sums depend on nothing but the elements.
void assemble(Part& part) {
  const int dofs_per_node = components(part.mesh.model);
  const Neighbours neighbours = neighbours_of(part.mesh.elements, part.nodes());
  part.lumped_mass = Eigen::VectorXd::Zero(part.nodes());
  part.stiffness = zeros(neighbours, part.nodes(), dofs_per_node);
  ElementCopies<ElementMatrix> copies(part.section.model);
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const Element& element = part.mesh.elements[at(e)];
    const ElementGeometry geometry = element_geometry(part.mesh, e);
    const Material& material = material_of(part, e);
    const ElementMatrix& stiffness = copies.of(
        geometry, [&](const ElementGeometry& first) { return element_stiffness(part.section, material, first); },
        material_index(part.mesh, e));
    const Eigen::VectorXd mass = element_lumped_mass(part.section, material, geometry);
    for (int i = 0; i < mass.size(); ++i) {
      const int row = element[at(i)], *const first = &neighbours.node[at(neighbours.start[at(row)])],
                *const end = first + (neighbours.start[at(row) + 1] - neighbours.start[at(row)]);
      part.lumped_mass[row] += mass[i];
      for (int j = 0; j < mass.size(); ++j) {
        const auto block = static_cast<int>(std::lower_bound(first, end, element[at(j)]) - first) * dofs_per_node;
        for (int r = 0; r < dofs_per_node; ++r) {
          double* const entry =
              part.stiffness.valuePtr() + part.stiffness.outerIndexPtr()[row * dofs_per_node + r] + block;
          for (int c = 0; c < dofs_per_node; ++c) entry[c] += stiffness(i * dofs_per_node + r, j * dofs_per_node + c);
        }
      }
    }
  }
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
  part.mesh.period_wide_m = whole.period_wide_m;
  part.mesh.rigid_nodes = whole.rigid_nodes;
  part.body_element = elements;
  std::sort(part.body_element.begin(), part.body_element.end());
  take_elements(whole, extra_nodes, part);
  take_groups_and_surfaces(whole, part);
  assemble(part);
  pass_on_masses(part.mesh.hanging, part.lumped_mass);
  eliminate(part.mesh.hanging, components(whole.model), part.stiffness);
  return part;
}

ElementGeometry element_geometry(const Mesh& mesh, int element) {
  const Element& nodes = mesh.elements[at(element)];
  const int columns = std::max(2, components(mesh.model));
  ElementGeometry geometry{nodes.kind, ElementCoordinates(nodes.size(), columns)};
  const Eigen::Vector3d& first = mesh.position[at(nodes[0])];
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    geometry.x.row(static_cast<Eigen::Index>(i)) =
        nearest_image(mesh, mesh.position[at(nodes[i])], first).head(columns).transpose();
  }
  return geometry;
}

double extent_along(const ElementGeometry& element, const Eigen::Vector3d& direction) {
  const Eigen::VectorXd along = element.x * direction.head(element.x.cols());
  return along.maxCoeff() - along.minCoeff();
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

namespace {

using FacePosition = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 4>;

FacePosition position_of(const Mesh& mesh, const Face& face) {
  FacePosition x(3, static_cast<Eigen::Index>(face.size()));
  const Eigen::Vector3d& first = mesh.position[at(face[0])];
  for (std::size_t i = 0; i < face.size(); ++i)
    x.col(static_cast<Eigen::Index>(i)) = nearest_image(mesh, mesh.position[at(face[i])], first);
  return x;
}

/// The area of a bilinear face, by two by two Gauss points.
FaceArea quadrilateral_area(const FacePosition& x) {
  constexpr double node_xi[4] = {-1.0, 1.0, 1.0, -1.0}, node_eta[4] = {-1.0, -1.0, 1.0, 1.0};
  const double gauss = 1.0 / std::sqrt(3.0);
  FaceArea area{};
  for (int q = 0; q < 4; ++q) {
    Eigen::Vector3d along_xi = Eigen::Vector3d::Zero(), along_eta = along_xi;
    double shape[4];
    for (int i = 0; i < 4; ++i) {
      const double of_xi = 0.5 * (1.0 + gauss * node_xi[i] * node_xi[q]),
                   of_eta = 0.5 * (1.0 + gauss * node_eta[i] * node_eta[q]);
      shape[i] = of_xi * of_eta;
      along_xi += 0.5 * node_xi[i] * of_eta * x.col(i);
      along_eta += 0.5 * node_eta[i] * of_xi * x.col(i);
    }
    const double size = along_xi.cross(along_eta).norm();
    for (std::size_t i = 0; i < 4; ++i) area[i] += size * shape[i];
  }
  return area;
}

}  // namespace

FaceArea face_area(const Section& section, const Mesh& mesh, const Face& face) {
  if (face.size() == 1) return {section.measure};
  const FacePosition x = position_of(mesh, face);
  if (face.size() == 2) {
    const Eigen::Vector2d area = edge_area(section, x.col(0).head<2>(), x.col(1).head<2>());
    return {area[0], area[1]};
  }
  if (face.size() == 4) return quadrilateral_area(x);
  const Eigen::Vector3d first = x.col(1) - x.col(0), second = x.col(2) - x.col(0);
  const double third = first.cross(second).norm() / 6.0;
  return {third, third, third};
}

Eigen::Vector3d face_normal(const Mesh& mesh, const Face& face) {
  const FacePosition x = position_of(mesh, face);
  if (face.size() == 2) {
    const Eigen::Vector2d along = (x.col(1) - x.col(0)).head<2>();
    const double length = along.norm();
    return {along[1] / length, -along[0] / length, 0.0};
  }
  const bool triangle = face.size() == 3;
  const Eigen::Vector3d first = x.col(triangle ? 1 : 2) - x.col(0),
                        second = x.col(triangle ? 2 : 3) - x.col(triangle ? 0 : 1);
  return first.cross(second).normalized();
}

double element_critical_time_step(const Part& part) {
  double largest = 0.0;
  ElementCopies<double> frequencies(part.section.model);
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const auto make = [&](const ElementGeometry& geometry) {
      return element_max_frequency_squared(part.section, material_of(part, e), geometry);
    };
    const double squared = frequencies.of(element_geometry(part.mesh, e), make, material_index(part.mesh, e));
    largest = std::max(largest, squared);
  }
  return largest > 0.0 ? 2.0 / std::sqrt(largest) : std::numeric_limits<double>::infinity();
}

namespace {

/// `traction_of` says of a face its force per area [Pa].
template <class TractionOf>
Eigen::VectorXd force_on_faces(const Part& part, const std::string& surface, const TractionOf& traction_of) {
  const int dofs_per_node = components(part.mesh.model);
  (void)surface_nodes(part.mesh, surface);  // refuses an unknown surface by name
  Eigen::VectorXd force = Eigen::VectorXd::Zero(part.dofs());
  for (const Face& face : part.mesh.surfaces.at(surface)) {
    const FaceArea area = face_area(part.section, part.mesh, face);
    const auto& traction_pa = traction_of(face);
    for (std::size_t i = 0; i < face.size(); ++i) {
      for (int c = 0; c < dofs_per_node; ++c) force[face[i] * dofs_per_node + c] += area[i] * traction_pa[at(c)];
    }
  }
  pass_on(part.mesh.hanging, dofs_per_node, force);
  return force;
}

}  // namespace

Eigen::VectorXd traction_force(const Part& part, const std::string& surface, const std::vector<double>& traction_pa) {
  return force_on_faces(part, surface, [&](const Face&) -> const std::vector<double>& { return traction_pa; });
}

Eigen::VectorXd pressure_force(const Part& part, const std::string& surface, double pressure_pa) {
  return force_on_faces(part, surface, [&](const Face& face) {
    const Eigen::Vector3d traction_pa = -pressure_pa * face_normal(part.mesh, face);
    return std::array<double, 3>{traction_pa[0], traction_pa[1], traction_pa[2]};
  });
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
