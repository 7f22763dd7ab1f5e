#include "common/solver/surface_stress.hpp"

#include <optional>

namespace ricochet::solver {
namespace {

/// Natural coordinates of the midpoint of the element's face (a, b); none if the element lacks it.
std::optional<fem::NaturalPoint> face_midpoint(const fem::Element& nodes, int a, int b) {
  const auto& kind = fem::traits(nodes.kind);
  for (const auto& [i, j] : kind.faces) {
    const int first = nodes[fem::at(i)], second = nodes[fem::at(j)];
    if ((first == a && second == b) || (first == b && second == a))
      return fem::NaturalPoint(0.5 * (kind.corner[fem::at(i)] + kind.corner[fem::at(j)]));
  }
  return std::nullopt;
}

}  // namespace

SurfaceStress::SurfaceStress(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts) {
  if (problem.contact.pairs.empty()) return;
  if (!collect(problem, parts, problem.contact.body_a, true) && problem.contact.body_b >= 0) {
    collect(problem, parts, problem.contact.body_b, false);
  }
}

bool SurfaceStress::collect(const scene::Problem& problem, const std::vector<scene::ParticipantPart>& parts, int body,
                            bool first) {
  const auto& surface = first ? problem.scene.contact->first.surface : problem.scene.contact->second->surface;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto& part = parts[p].part;
    const auto found = part.mesh.surfaces.find(surface);
    if (parts[p].body != body || found == part.mesh.surfaces.end()) continue;
    model_ = part.mesh.model;
    part_ = static_cast<int>(p);
    const int components = fem::components(model_);
    for (const auto& [a, b] : found->second) {
      for (int element = 0; element < static_cast<int>(part.mesh.elements.size()); ++element) {
        const fem::Element& nodes = part.mesh.elements[fem::at(element)];
        const auto midpoint = face_midpoint(nodes, a, b);
        if (!midpoint) continue;
        Edge edge;
        const auto& first_end = part.mesh.position[static_cast<std::size_t>(a)];
        const auto second_end =
            fem::nearest_image(part.mesh, part.mesh.position[static_cast<std::size_t>(b)], first_end);
        edge.area_m2 = fem::edge_area(part.section, first_end, second_end).sum();
        const auto geometry = fem::element_geometry(part.mesh, element);
        const int size = static_cast<int>(nodes.size()) * components;
        edge.stress_of_displacement.resize(fem::stress_components(model_), size);
        for (int i = 0; i < size; ++i) {
          edge.dofs.push_back(nodes[fem::at(i / components)] * components + i % components);
          edge.stress_of_displacement.col(i) =
              fem::element_stress(part.section, part.material, geometry, fem::ElementVector::Unit(size, i), *midpoint);
        }
        area_m2_ += edge.area_m2;
        edges_.push_back(std::move(edge));
      }
    }
    if (!edges_.empty()) return true;
  }
  return false;
}

double SurfaceStress::smallest_principal(const Edge& edge, const Eigen::Ref<const Eigen::VectorXd>& u) const {
  fem::ElementVector nodal(static_cast<Eigen::Index>(edge.dofs.size()));
  for (std::size_t i = 0; i < edge.dofs.size(); ++i) nodal[static_cast<Eigen::Index>(i)] = u[edge.dofs[i]];
  const fem::StressVector stress = edge.stress_of_displacement * nodal;
  if (model_ == fem::Model::bar) return stress[0];  // the lateral principal stresses of a bar are zero
  return fem::principal_stresses(model_, stress)[2];
}

}  // namespace ricochet::solver
