#include "common/contact/surface_stress.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace ricochet::solver {
namespace {

/// Elements by their faces, of those faces alone whose nodes are all on the surface.
std::map<fem::Face, std::vector<int>> elements_by_face(const fem::Mesh& mesh, const std::vector<fem::Face>& surface) {
  std::vector<bool> on_surface(mesh.position.size(), false);
  for (const fem::Face& face : surface) {
    for (const int node : face) on_surface[fem::at(node)] = true;
  }
  std::map<fem::Face, std::vector<int>> elements;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const fem::Element& nodes = mesh.elements[fem::at(e)];
    for (fem::Face face : fem::traits(nodes.kind).faces) {
      for (int& node : face) node = nodes[fem::at(node)];
      if (std::all_of(face.begin(), face.end(), [&](int node) { return on_surface[fem::at(node)]; }))
        elements[fem::sorted(face)].push_back(e);
    }
  }
  return elements;
}

/// Natural coordinates of the middle of the element's face; none if the element lacks it.
std::optional<fem::NaturalPoint> face_middle(const fem::Element& nodes, const fem::Face& wanted) {
  const auto& kind = fem::traits(nodes.kind);
  for (const fem::Face& own : kind.faces) {
    fem::Face face = own;
    for (int& node : face) node = nodes[fem::at(node)];
    if (fem::sorted(face) != fem::sorted(wanted)) continue;
    fem::NaturalPoint sum = fem::NaturalPoint::Zero();
    for (const int corner : own) sum += kind.corner[fem::at(corner)];
    return fem::NaturalPoint(sum / static_cast<double>(own.size()));
  }
  return std::nullopt;
}

}  // namespace

SurfaceStress::SurfaceStress(const scene::Problem& problem, const std::vector<BodyState>& states) {
  if (problem.contacts.empty()) return;
  const auto& contact = problem.contacts.front();
  int first = contact.body_a, second = contact.body_b;
  if (contact.second_named_first) std::swap(first, second);
  if (!collect(problem, states, first, true) && second >= 0) collect(problem, states, second, false);
}

bool SurfaceStress::collect(const scene::Problem& problem, const std::vector<BodyState>& states, int body, bool first) {
  const auto& surface = first ? problem.scene.contact_law().first.surface : problem.scene.contact_law().second->surface;
  const std::vector<int> touching = scene::contact_nodes(problem.contacts.front(), body);
  for (std::size_t p = 0; p < states.size(); ++p) {
    const auto& part = states[p].part;
    const auto found = part.mesh.surfaces.find(surface);
    if (states[p].body != body || found == part.mesh.surfaces.end()) continue;
    model_ = part.mesh.model;
    part_ = static_cast<int>(p);
    plastic_ = states[p].plastic;
    const int components = fem::components(model_);
    const auto elements = elements_by_face(part.mesh, found->second);
    const auto may_touch = [&](int node) {
      return std::binary_search(touching.begin(), touching.end(), part.body_node[fem::at(node)]);
    };
    for (const fem::Face& face : found->second) {
      const auto behind = elements.find(fem::sorted(face));
      if (behind == elements.end() || std::none_of(face.begin(), face.end(), may_touch)) continue;
      for (const int element : behind->second) {
        const fem::Element& nodes = part.mesh.elements[fem::at(element)];
        const auto middle = face_middle(nodes, face);
        if (!middle) continue;
        Element own;
        own.element = element;
        const fem::FaceArea area = fem::face_area(part.section, part.mesh, face);
        own.area_m2 = std::accumulate(area.begin(), area.end(), 0.0);
        const auto geometry = fem::element_geometry(part.mesh, element);
        const int size = static_cast<int>(nodes.size()) * components;
        own.stress_of_displacement.resize(fem::stress_components(model_), size);
        for (int i = 0; i < size; ++i) {
          own.dofs.push_back(nodes[fem::at(i / components)] * components + i % components);
          own.stress_of_displacement.col(i) = fem::element_stress(part.section, fem::material_of(part, element),
                                                                  geometry, fem::ElementVector::Unit(size, i), *middle);
        }
        area_m2_ += own.area_m2;
        elements_.push_back(std::move(own));
      }
    }
    if (!elements_.empty()) return true;
  }
  return false;
}

double SurfaceStress::smallest_principal(const Element& own, const Eigen::Ref<const Eigen::VectorXd>& u) const {
  fem::ElementVector nodal(static_cast<Eigen::Index>(own.dofs.size()));
  for (std::size_t i = 0; i < own.dofs.size(); ++i) nodal[static_cast<Eigen::Index>(i)] = u[own.dofs[i]];
  fem::StressVector stress = own.stress_of_displacement * nodal;
  if (plastic_) stress -= plastic_->stress_of(own.element);
  return fem::principal_stresses(model_, stress)[2];
}

}  // namespace ricochet::solver
