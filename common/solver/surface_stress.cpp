#include "common/solver/surface_stress.hpp"

#include <array>

namespace ricochet::solver {
namespace {

/// Natural coordinates of the midpoint of the element edge (a, b); nullptr-like {2, 2} if the element lacks the edge.
std::array<double, 2> edge_midpoint(const fem::Mesh& mesh, int element, int a, int b) {
  const auto& nodes = mesh.elements[static_cast<std::size_t>(element)];
  if (mesh.model == fem::Model::bar) {
    if (nodes[0] == a) return {-1.0, 0.0};
    if (nodes[1] == a) return {1.0, 0.0};
    return {2.0, 2.0};
  }
  constexpr std::array<std::array<double, 2>, 4> midpoint = {{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const int first = nodes[i];
    const int second = nodes[(i + 1) % 4];
    if ((first == a && second == b) || (first == b && second == a)) return midpoint[i];
  }
  return {2.0, 2.0};
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
        const auto [xi, eta] = edge_midpoint(part.mesh, element, a, b);
        if (xi > 1.5) continue;
        Edge edge;
        const auto& first_end = part.mesh.position[static_cast<std::size_t>(a)];
        const auto second_end =
            fem::nearest_image(part.mesh, part.mesh.position[static_cast<std::size_t>(b)], first_end);
        edge.area_m2 = fem::edge_area(part.section, first_end, second_end).sum();
        const auto x = fem::element_coordinates(part.mesh, element);
        const int size = fem::nodes_per_element(model_) * components;
        edge.stress_of_displacement.resize(fem::stress_components(model_), size);
        for (int i = 0; i < size; ++i) {
          const auto node =
              part.mesh.elements[static_cast<std::size_t>(element)][static_cast<std::size_t>(i / components)];
          edge.dofs.push_back(node * components + i % components);
          edge.stress_of_displacement.col(i) =
              fem::element_stress(part.section, part.material, x, fem::ElementVector::Unit(size, i), xi, eta);
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
