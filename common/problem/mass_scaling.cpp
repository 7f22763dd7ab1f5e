#include "common/problem/mass_scaling.hpp"

#include <algorithm>

#include "common/fem/element_copies.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"

namespace ricochet::scene {
namespace {

/// Per node of an element [kg].
Eigen::VectorXd added_to(const BodyProblem& body, int element) {
  return (body.density_factor[at(element)] - 1.0) * fem::element_lumped_mass(body.section,
                                                                             fem::material_of(body, element),
                                                                             fem::element_geometry(body.mesh, element));
}

}  // namespace

void scale_mass(const Scene& scene, BodyProblem& body) {
  if (!scene.mass_scaling_step_s) return;
  const double needed_s = *scene.mass_scaling_step_s / scene.time.safety_factor;
  fem::ElementCopies<double> copies(body.section.model);
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    const auto make = [&](const fem::ElementGeometry& geometry) {
      return fem::element_max_frequency_squared(body.section, fem::material_of(body, e), geometry);
    };
    const double frequency_squared =
        copies.of(fem::element_geometry(body.mesh, e), make, fem::material_index(body.mesh, e));
    body.density_factor.push_back(std::max(1.0, 0.25 * frequency_squared * needed_s * needed_s));
  }
}

fem::Part body_part(const BodyProblem& body, const std::vector<int>& elements, const std::vector<int>& extra_nodes) {
  fem::Part part = fem::extract_part(body.mesh, body.name, body.section, body.material, elements, extra_nodes);
  if (body.density_factor.empty()) return part;
  for (std::size_t e = 0; e < part.body_element.size(); ++e) {
    if (body.density_factor[at(part.body_element[e])] == 1.0) continue;
    const Eigen::VectorXd added = added_to(body, part.body_element[e]);
    for (Eigen::Index i = 0; i < added.size(); ++i)
      part.lumped_mass[part.mesh.elements[e][static_cast<std::size_t>(i)]] += added[i];
  }
  fem::pass_on_masses(part.mesh.hanging, part.lumped_mass);
  return part;
}

void add_scaled_mass(const BodyProblem& body, Eigen::VectorXd& mass) {
  for (int e = 0; e < static_cast<int>(body.density_factor.size()); ++e) {
    if (body.density_factor[at(e)] == 1.0) continue;
    const Eigen::VectorXd added = added_to(body, e);
    for (Eigen::Index i = 0; i < added.size(); ++i)
      mass[body.mesh.elements[at(e)][static_cast<std::size_t>(i)]] += added[i];
  }
}

AddedMass added_mass(const Problem& problem, int index) {
  const BodyProblem& body = problem.bodies[at(index)];
  AddedMass added;
  if (body.density_factor.empty()) return added;
  const auto scaled = [&](int e) { return body.density_factor[at(e)] > 1.0; };
  const int elements = static_cast<int>(body.density_factor.size());
  for (int e = 0; e < elements; ++e) {
    if (!scaled(e)) continue;
    ++added.elements;
    added.kg += added_to(body, e).sum();
    added.largest_factor = std::max(added.largest_factor, body.density_factor[at(e)]);
  }
  added.share = added.kg / (body_lumped_mass(body).sum() - added.kg);
  for (const ContactGeometry& contact : problem.contacts) {
    const std::vector<bool> touches = elements_at(body.mesh, contact_nodes({contact}, index));
    AddedMass::AtContact here{contact.name, 0};
    for (int e = 0; e < elements; ++e) here.elements += touches[at(e)] && scaled(e) ? 1 : 0;
    if (here.elements > 0) added.contacts.push_back(here);
  }
  return added;
}

}  // namespace ricochet::scene
