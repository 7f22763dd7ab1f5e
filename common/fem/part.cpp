#include "common/fem/part.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

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

/// Faces of the elements. A face inside the body belongs, in the direction that has the body behind it, to one element
/// only, so a surface's loads are never taken by two parts.
std::set<Face> faces(const Mesh& mesh) {
  std::set<Face> faces;
  for (const auto& element : mesh.elements) {
    for (Face face : traits(element.kind).faces) {
      for (int& node : face) node = element[at(node)];
      faces.insert(from_smallest(face));
    }
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
  for (const auto& [name, faces_of_whole] : whole.surfaces) {
    auto& surface = part.mesh.surfaces[name];
    for (Face face : faces_of_whole) {
      for (int& node : face) node = local_index(part.body_node, node);
      if (own.contains(from_smallest(face))) surface.push_back(face);
    }
  }
}

/// Stiffness and mass of an element.
struct Matrices {
  ElementMatrix stiffness;
  Eigen::VectorXd mass;
};

/// Of the elements of a part, those of a solid's distinct elements found once: copies have the same places of their
/// nodes relative to the first one (traits' `relative`) and with them the same matrices to the last bit.
class ElementCopies {
 public:
  explicit ElementCopies(const Part& part) : part_(part) {}

  const Matrices& of(int element) {
    const ElementGeometry geometry = element_geometry(part_.mesh, element);
    const auto relative = traits(geometry.kind).relative;
    if (relative == nullptr) return latest_ = make(geometry);
    const ElementCoordinates x = relative(geometry.x);
    std::vector<double> key(x.data(), x.data() + x.size());
    const auto found = known_.find(key);
    return (found != known_.end() ? found : known_.insert({std::move(key), make(geometry)}).first)->second;
  }

 private:
  [[nodiscard]] Matrices make(const ElementGeometry& geometry) const {
    return {element_stiffness(part_.section, part_.material, geometry),
            element_lumped_mass(part_.section, part_.material, geometry)};
  }

  const Part& part_;
  std::map<std::vector<double>, Matrices> known_;
  Matrices latest_;
};

/// Element by element in ascending order, every entry of an element kept even if zero: the structure is symmetric and
/// the sums depend on nothing but the elements.
void assemble(Part& part) {
  const int dofs_per_node = components(part.mesh.model);
  part.lumped_mass = Eigen::VectorXd::Zero(part.nodes());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(part.mesh.elements.size() * (dofs_per_node == 3 ? 576 : 64));
  ElementCopies copies(part);
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    const auto& nodes = part.mesh.elements[at(e)];
    const auto& [stiffness, mass] = copies.of(e);
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
  part.mesh.period_wide_m = whole.period_wide_m;
  part.body_element = elements;
  std::sort(part.body_element.begin(), part.body_element.end());
  take_elements(whole, extra_nodes, part);
  take_groups_and_surfaces(whole, part);
  assemble(part);
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

/// Of a bilinear face, by two by two Gauss points.
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
  for (const Face& face : part.mesh.surfaces.at(surface)) {
    const FaceArea area = face_area(part.section, part.mesh, face);
    for (std::size_t i = 0; i < face.size(); ++i) {
      for (int c = 0; c < dofs_per_node; ++c) {
        force[face[i] * dofs_per_node + c] += area[i] * traction_pa[at(c)];
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
