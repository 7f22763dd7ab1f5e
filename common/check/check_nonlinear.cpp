#include "common/check/check_nonlinear.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <variant>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

/// A body whose elements do not answer linearly.
struct Nonlinear {
  const Problem& problem;
  const BodyProblem& body;
  std::string key;    ///< of the body, that says so
  std::string found;  ///< in an error
  std::string they;   ///< "bodies" with this are such ones

  [[nodiscard]] const ParticipantSpec* owner(Role role) const {
    for (const ParticipantSpec& participant : problem.scene.participants) {
      if (participant.role != role) continue;
      const std::vector<bool> owned = owned_elements(problem.scene, body, participant);
      if (std::find(owned.begin(), owned.end(), true) != owned.end()) return &participant;
    }
    return nullptr;
  }
  [[noreturn]] void refuse(const std::string& with, const std::string& allowed) const {
    throw ConfigError(fmt::format("{}: found {} {}; allowed: {}", problem.scene.where("body." + body.name + "." + key),
                                  this->found, with, allowed));
  }
};

void check_elements(const Nonlinear& nonlinear) {
  for (const fem::Element& element : nonlinear.body.mesh.elements) {
    if (fem::traits(element.kind).points) continue;
    const bool plane = element.kind == fem::ElementKind::triangle;
    nonlinear.refuse(fmt::format("of {}, which lock when they yield", plane ? "triangles" : "tetrahedra"),
                     plane ? "a mesh of quadrilaterals alone" : "a mesh of hexahedra alone");
  }
}

void check_protocol(const Nonlinear& nonlinear) {
  const ProtocolTraits& protocol = nonlinear.problem.scene.coupling.protocol;
  const std::string name = fmt::format("under \"{}\"", protocol.name);
  const std::string others = "\"hughes_liu\", \"kim\", \"fixed_point\" or \"prakash_hjelmstad\" without substeps";
  const ParticipantSpec* const on_explicit_side = nonlinear.owner(Role::explicit_solver);
  if (protocol.name == "belytschko_mullen" && on_explicit_side)
    nonlinear.refuse(fmt::format("{} on the side of \"{}\", whose stiffness of the start serves for all windows", name,
                                 on_explicit_side->name),
                     others + ", or bodies " + nonlinear.they + " on the implicit side alone");
  if (protocol.name == "gravouil_combescure" && nonlinear.owner(Role::implicit_solver))
    nonlinear.refuse(name + " on the implicit side, whose answer of the start serves for all windows", others);
  if (protocol.dual && on_explicit_side && on_explicit_side->substeps > 1)
    nonlinear.refuse(fmt::format("{} with {} substeps of \"{}\", whose answer of the start serves for all windows",
                                 name, on_explicit_side->substeps, on_explicit_side->name),
                     "substeps = 1, or bodies " + nonlinear.they + " on the implicit side alone");
}

void check_contact_law(const Nonlinear& nonlinear) {
  const Scene& scene = nonlinear.problem.scene;
  if (scene.contacts.empty()) return;
  if (scene.massless_contact())
    nonlinear.refuse(
        "with multiplier_update = \"massless\", which balances contact nodes by the stiffness of the start",
        "\"trapezoidal_reset\" or, with an implicit side, \"fully_implicit\"");
  if (scene.contact_law().enforcement == Enforcement::penalty && nonlinear.owner(Role::implicit_solver))
    nonlinear.refuse("with enforcement = \"penalty\" on the implicit side", "enforcement = \"multiplier\"");
}

/// Small steps begin with the strain of the part, of which no rank knows all.
void check_ranks(const Nonlinear& nonlinear) {
  for (const ParticipantSpec& participant : nonlinear.problem.scene.participants)
    if (participant.ranks.value_or(1) > 1 && !nonlinear.body.small_steps.empty())
      nonlinear.refuse(fmt::format("in small steps with {} ranks of \"{}\"", *participant.ranks, participant.name),
                       "no ranks (and threads), or \"all_explicit\"");
}

/// Surroundings that act along directions of the start would go on acting along those.
void check_surroundings(const Nonlinear& turns, const Body& spec) {
  if (!spec.absorbing.empty())
    turns.refuse("of a body with an absorbing surface, whose dashpots keep their directions", "no absorbing surface");
  if (const auto* mesh = spec.structured(); mesh != nullptr && mesh->periodic_across)
    turns.refuse("of a periodic mesh, whose images do not turn", "periodic_across = false");
  for (const ContactGeometry& contact : turns.problem.contacts) {
    const int index = static_cast<int>(&turns.body - turns.problem.bodies.data());
    if (contact.body_b < 0) continue;
    for (const int node : contact_nodes(contact, index)) {
      if (turns.body.turned_by[at(node)] >= 0) continue;  // held in all directions
      for (int c = 0; c < turns.problem.scene.components(); ++c)
        if (turns.body.fixed_dof[at(node * turns.problem.scene.components() + c)])
          turns.refuse("of a body with a support at its contact surface", "supports away from the contact surface");
    }
  }
}

}  // namespace

void check_nonlinear(const Problem& problem) {
  const auto check = [](const Nonlinear& nonlinear) {
    check_protocol(nonlinear);
    check_contact_law(nonlinear);
  };
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const BodyProblem& body = problem.bodies[i];
    if (problem.scene.bodies[i].yields()) {
      const Nonlinear yields{problem, body, "material.plasticity", "plasticity", "that yield"};
      check_elements(yields);
      check(yields);
    }
    if (problem.scene.bodies[i].large_rotation) {
      const Nonlinear turns{problem, body, "large_rotation", "large_rotation", "that turn"};
      check_surroundings(turns, problem.scene.bodies[i]);
      check(turns);
      check_ranks(turns);
    }
  }
}

}  // namespace ricochet::scene
