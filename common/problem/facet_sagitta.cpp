#include "common/problem/facet_sagitta.hpp"

#include <algorithm>

#include "common/problem/contact_side.hpp"

namespace ricochet::scene {
namespace {

/// The body's node in the pair that is nearest.
int nearest_node(const Problem& problem, const ContactGeometry& contact, const BodyProblem* body) {
  const auto nearest = std::min_element(contact.pairs.begin(), contact.pairs.end(),
                                        [](const ContactPair& p, const ContactPair& q) { return p.gap0_m < q.gap0_m; });
  if (body == &problem.bodies[at(contact.body_a)]) return nearest->node_a;
  return std::max_element(nearest->b.begin(), nearest->b.end(),
                          [](const WeightedNode& x, const WeightedNode& y) { return x.weight < y.weight; })
      ->node;
}

CurvedFacets facets_at(const ContactSide& side, int node) {
  CurvedFacets found{side.name, 0.0, 0.0};
  for (const surface::SurfaceFace& face : faces_of(side)) {
    if (std::find(face.node.begin(), face.node.end(), node) == face.node.end()) continue;
    const std::size_t corners = face.node.size();
    surface::ShapeValues middle = surface::ShapeValues::Zero();
    Eigen::Vector3d chord = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < corners; ++i) {
      middle[static_cast<Eigen::Index>(i)] = 1.0 / static_cast<double>(corners);
      chord += face.x[i] / static_cast<double>(corners);
      found.edge_m = std::max(found.edge_m, (face.x[(i + 1) % corners] - face.x[i]).norm());
    }
    found.sagitta_m = std::max(found.sagitta_m, (surface::place_at(face, middle) - chord).norm());
  }
  return found;
}

}  // namespace

std::vector<CurvedFacets> curved_facets(const Problem& problem, std::size_t contact) {
  std::vector<CurvedFacets> facets;
  const ContactContext context{problem.scene, problem.scene.contacts[contact]};
  const ContactGeometry& geometry = problem.contacts[contact];
  const auto take = [&](const SurfaceName& name, const std::vector<double>& normal) {
    const ContactSide side = make_side(context, problem.bodies, name, normal, geometry.normal);
    if (!side.flat) facets.push_back(facets_at(side, nearest_node(problem, geometry, side.body)));
  };
  if (geometry.pairs.empty()) return facets;
  take(context.contact.first, context.contact.normal);
  if (context.contact.second) take(*context.contact.second, {});
  return facets;
}

}  // namespace ricochet::scene
