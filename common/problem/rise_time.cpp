#include "common/problem/rise_time.hpp"

#include <algorithm>
#include <limits>

#include "common/fem/element.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

/// Among a body's nodes of a contact, each with the shallowest element there, the largest depth along the normal [m].
double contact_depth(const BodyProblem& body, const std::vector<int>& nodes, const Eigen::Vector3d& normal) {
  std::vector<double> depth_m(body.mesh.position.size(), -1.0);
  for (const int node : nodes) depth_m[at(node)] = std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const auto& element = body.mesh.elements[at(e)];
    if (std::none_of(element.begin(), element.end(), [&](int node) { return depth_m[at(node)] >= 0.0; })) continue;
    const double own_m = fem::extent_along(fem::element_geometry(body.mesh, e), normal);
    for (const int node : element) depth_m[at(node)] = std::min(depth_m[at(node)], own_m);
  }
  for (const int node : nodes) largest = std::max(largest, depth_m[at(node)]);
  return largest;
}

}  // namespace

double rise_time_s(const Problem& problem, const ContactGeometry& contact) {
  double longest_s = 0.0;
  for (const int index : {contact.body_a, contact.body_b}) {
    if (index < 0) continue;
    const BodyProblem& body = problem.bodies[at(index)];
    if (body.mesh.rigid_nodes > 0) continue;  // no wave crosses it
    const double speed = fem::longitudinal_wave_speed(body.section.model, contact_material(problem, contact, index));
    longest_s = std::max(longest_s, 2.0 * contact_depth(body, contact_nodes(contact, index), contact.normal) / speed);
  }
  return longest_s;
}

double rise_time_s(const Problem& problem) {
  double longest_s = 0.0;
  for (const ContactGeometry& contact : problem.contacts)
    longest_s = std::max(longest_s, rise_time_s(problem, contact));
  return longest_s;
}

}  // namespace ricochet::scene
