#include "common/problem/drawing.hpp"

#include <algorithm>

namespace ricochet::scene {
namespace {

void add(const BodyProblem& body, const std::vector<int>& nodes, DrawnMark& mark) {
  for (const int node : nodes) mark.places_m.push_back(body.mesh.position[fem::at(node)]);
}

/// The nodes that carry a rigid body lie inside it, where nobody looks for the contact.
std::vector<int> seen_nodes(const Problem& problem, std::size_t contact, int body) {
  const auto& of = problem.bodies[fem::at(body)];
  if (of.mesh.rigid_nodes == 0) return contact_nodes(problem.contacts[contact], body);
  const Contact& named = problem.scene.contacts[contact];
  return fem::surface_nodes(of.mesh, named.first.body == of.name ? named.first.surface : named.second->surface);
}

/// Nodes of the surfaces that a list of each body names.
template <class Entries>
DrawnMark of_surfaces(const Problem& problem, DrawnMark::Kind kind, Entries Body::*entries) {
  DrawnMark mark{kind, "", {}};
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const auto& body = problem.bodies[b];
    for (const auto& entry : problem.scene.bodies[b].*entries)
      add(body, fem::surface_nodes(body.mesh, entry.surface), mark);
  }
  return mark;
}

}  // namespace

std::vector<DrawnBody> drawn_bodies(const Problem& problem) {
  std::vector<DrawnBody> drawn;
  for (const auto& body : problem.bodies) {
    std::vector<int> owner(body.mesh.elements.size(), 0);
    for (std::size_t p = 0; p < problem.scene.participants.size(); ++p) {
      const auto owned = owned_elements(problem.scene, body, problem.scene.participants[p]);
      for (std::size_t e = 0; e < owned.size(); ++e) {
        if (owned[e]) owner[e] = static_cast<int>(p);
      }
    }
    drawn.push_back({fem::seen_cells(body.mesh), {}});
    for (const int element : drawn.back().seen.element) drawn.back().owner.push_back(owner[fem::at(element)]);
  }
  return drawn;
}

std::vector<DrawnMark> drawn_marks(const Problem& problem) {
  using Kind = DrawnMark::Kind;
  std::vector<DrawnMark> marks;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    marks.push_back({Kind::contact, problem.contacts[i].name, {}});
    for (const int body : {problem.contacts[i].body_a, problem.contacts[i].body_b}) {
      if (body >= 0) add(problem.bodies[fem::at(body)], seen_nodes(problem, i, body), marks.back());
    }
  }
  marks.push_back(of_surfaces(problem, Kind::support, &Body::supports));
  marks.push_back(of_surfaces(problem, Kind::load, &Body::tractions));
  marks.push_back(of_surfaces(problem, Kind::prescribed, &Body::prescribed));
  marks.push_back(of_surfaces(problem, Kind::absorbing, &Body::absorbing));
  marks.push_back({Kind::joint, "", {}});
  for (const auto& joint : problem.joints) add(problem.bodies[fem::at(joint.body)], joint.nodes, marks.back());
  marks.push_back({Kind::interface, "", {}});
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const auto shared = shared_nodes(problem, static_cast<int>(b));
    for (std::size_t node = 0; node < shared.size(); ++node) {
      if (shared[node]) marks.back().places_m.push_back(problem.bodies[b].mesh.position[node]);
    }
  }
  marks.push_back({Kind::probe, "", {}});
  for (const auto& probe : problem.scene.output.probes) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    std::copy(probe.at_m.begin(), probe.at_m.end(), x.data());
    marks.back().places_m.push_back(x);
  }
  return marks;
}

}  // namespace ricochet::scene
