#include "coupler/watch/untold.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace ricochet::coupler {
namespace {

/// All that acts on a body besides contact and joints, of what these elements have a part in.
struct Actions {
  bool works = false;   ///< it changes the energy
  bool pushes = false;  ///< it changes the momentum
};

/// Surfaces on which something acts; `works`: with what moves the body, not with supports.
std::vector<std::string> surfaces_of(const scene::Body& body, bool works) {
  std::vector<std::string> names;
  const auto add = [&names](const auto& actions) {
    std::transform(actions.begin(), actions.end(), std::back_inserter(names), [](const auto& a) { return a.surface; });
  };
  add(body.tractions);
  add(body.prescribed);
  add(body.absorbing);
  if (!works) add(body.supports);
  return names;
}

/// Nobody knows what holds a foreign body; its work is its own affair.
Actions actions_on(const scene::Problem& problem, const PeerDescription& description, const std::string& name) {
  if (problem.scene.is_foreign(name)) return {false, true};
  const auto is = [&](const scene::BodyProblem& body) { return body.name == name; };
  const auto body = std::find_if(problem.bodies.begin(), problem.bodies.end(), is);
  if (body == problem.bodies.end()) return {};
  const auto& spec = problem.scene.body(name);
  const auto& g = spec.gravity_m_s2;
  const bool falls = std::any_of(g.begin(), g.end(), [](double x) { return x != 0.0; });
  const auto owned = scene::owned_elements(problem.scene, *body, problem.scene.participant(description.participant));
  std::vector<bool> touched(body->mesh.position.size(), false);
  for (std::size_t e = 0; e < owned.size(); ++e) {
    for (const int node : body->mesh.elements[e]) touched[fem::at(node)] = touched[fem::at(node)] || owned[e];
  }
  const auto touches = [&](const std::string& surface) {
    const auto nodes = fem::surface_nodes(body->mesh, surface);
    return std::any_of(nodes.begin(), nodes.end(), [&](int node) { return touched[fem::at(node)]; });
  };
  const auto any_of = [&](bool works) {
    const auto names = surfaces_of(spec, works);
    return std::any_of(names.begin(), names.end(), touches);
  };
  const int index = static_cast<int>(body - problem.bodies.begin());
  const auto rigid = [&](const scene::ContactGeometry& contact) {
    return contact.body_a == index && contact.body_b < 0 && description.contact_owner;
  };
  const bool stopped = std::any_of(problem.contacts.begin(), problem.contacts.end(), rigid);
  return {falls || any_of(true), falls || stopped || any_of(false)};
}

std::vector<std::string> directions_of(scene::Model model) {
  if (model == scene::Model::solid) return {"n", "t", "b"};
  if (model == scene::Model::plane_strain) return {"n", "t"};
  return {"n"};
}

}  // namespace

Untold untold(const scene::Problem& problem, const std::vector<PeerDescription>& descriptions) {
  Untold result;
  const auto directions = directions_of(problem.scene.model);
  for (const auto& description : descriptions) {
    const auto& told = description.record_columns;
    std::string energy, momentum, interface;
    const auto need = [&told](std::string& missing, const std::string& column) {
      if (missing.empty() && std::find(told.begin(), told.end(), column) == told.end()) missing = column;
    };
    const bool whole = std::find(told.begin(), told.end(), "energy_interface_j") != told.end();
    for (const auto& body : description.bodies) {
      const auto actions = actions_on(problem, description, body);
      need(energy, "energy_kinetic_j/" + body);
      need(energy, "energy_strain_j/" + body);
      if (actions.works) need(energy, "energy_external_j/" + body);
      if (!problem.scene.is_foreign(body) && problem.scene.body(body).yields()) need(energy, "plastic_work_j/" + body);
      if (!whole) need(interface, "energy_interface_j/" + body);
      for (const auto& direction : directions) {
        need(momentum, fmt::format("momentum_{}_kg_m_s/{}", direction, body));
        if (actions.pushes) need(momentum, fmt::format("impulse_{}_kg_m_s/{}", direction, body));
      }
    }
    if (description.contact_owner && problem.scene.friction()) need(energy, "energy_friction_j");
    const auto add = [&](const std::string& missing, std::vector<std::string>& names) {
      if (!missing.empty()) names.push_back(fmt::format("participant '{}' ({})", description.participant, missing));
    };
    add(energy, result.energy);
    add(momentum, result.momentum);
    add(interface, result.interface);
  }
  return result;
}

}  // namespace ricochet::coupler
