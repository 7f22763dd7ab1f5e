#include "common/check/check_mass_scaling.hpp"

#include <fmt/format.h>

#include "common/problem/mass_scaling.hpp"

namespace ricochet::scene {
namespace {

std::string name_of(const AddedMass::AtContact& contact) {
  return contact.name.empty() ? std::string("the contact") : fmt::format("contact \"{}\"", contact.name);
}

void tell_body(const BodyProblem& body, const AddedMass& added, Plan& plan) {
  plan.notes.push_back(fmt::format(
      "mass scaling of body \"{}\": {} of {} elements get up to {:.4g} times their density, {:.6g} kg ({:.3g} %) more "
      "in all; momenta and energies, those of the start among them, are of the scaled mass",
      body.name, added.elements, body.mesh.elements.size(), added.largest_factor, added.kg, 100.0 * added.share));
  for (const AddedMass::AtContact& contact : added.contacts)
    plan.warnings.push_back(fmt::format(
        "mass scaling makes {} element{} of body \"{}\" at {} heavier: the impact comes to its force late and "
        "is heavier than that of the body (docs/limits.md, 17); a smaller mass_scaling.step_s, "
        "\"local_explicit\" or a hybrid protocol has less of it",
        contact.elements, contact.elements == 1 ? "" : "s", body.name, name_of(contact)));
}

}  // namespace

void check_mass_scaling(const Problem& problem, Plan& plan) {
  if (!problem.scene.mass_scaling_step_s) return;
  double scaled_kg = 0.0;
  for (int index = 0; index < static_cast<int>(problem.bodies.size()); ++index) {
    const AddedMass added = added_mass(problem, index);
    scaled_kg += plan.bodies[static_cast<std::size_t>(index)].mass_kg;
    plan.added_mass_kg += added.kg;
    if (added.elements > 0) tell_body(problem.bodies[static_cast<std::size_t>(index)], added, plan);
  }
  plan.added_mass_share = plan.added_mass_kg / (scaled_kg - plan.added_mass_kg);
  if (plan.added_mass_kg == 0.0)
    plan.notes.push_back(fmt::format("mass scaling adds nothing: every element bears a step of {:.6g} s",
                                     *problem.scene.mass_scaling_step_s));
}

}  // namespace ricochet::scene
