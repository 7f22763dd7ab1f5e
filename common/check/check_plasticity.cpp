#include "common/check/check_plasticity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "common/base/error.hpp"

namespace ricochet::scene {
namespace {

/// Bodies that yield, with who owns such elements of them.
struct Yielding {
  const Problem& problem;
  const BodyProblem& body;

  [[nodiscard]] const ParticipantSpec* owner(Role role) const {
    for (const ParticipantSpec& participant : problem.scene.participants) {
      if (participant.role != role) continue;
      const std::vector<bool> owned = owned_elements(problem.scene, body, participant);
      if (std::find(owned.begin(), owned.end(), true) != owned.end()) return &participant;
    }
    return nullptr;
  }
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    throw ConfigError(fmt::format("{}: found plasticity {}; allowed: {}",
                                  problem.scene.where("body." + body.name + ".material.plasticity"), found, allowed));
  }
};

void check_elements(const Yielding& yielding) {
  for (const fem::Element& element : yielding.body.mesh.elements) {
    if (fem::traits(element.kind).points) continue;
    const bool plane = element.kind == fem::ElementKind::triangle;
    yielding.refuse(fmt::format("of {}, which lock when they yield", plane ? "triangles" : "tetrahedra"),
                    plane ? "a mesh of quadrilaterals alone" : "a mesh of hexahedra alone");
  }
}

void check_protocol(const Yielding& yielding) {
  const ProtocolTraits& protocol = yielding.problem.scene.coupling.protocol;
  const std::string name = fmt::format("under \"{}\"", protocol.name);
  if (protocol.local_steps) yielding.refuse(name + ", whose small steps split K", "\"all_explicit\"");
  const std::string others = "\"hughes_liu\", \"kim\", \"fixed_point\" or \"prakash_hjelmstad\" without substeps";
  const ParticipantSpec* const on_explicit_side = yielding.owner(Role::explicit_solver);
  if (protocol.name == "belytschko_mullen" && on_explicit_side)
    yielding.refuse(fmt::format("{} on the side of \"{}\", whose stiffness of the start serves for all windows", name,
                                on_explicit_side->name),
                    others + ", or bodies that yield on the implicit side alone");
  if (protocol.name == "gravouil_combescure" && yielding.owner(Role::implicit_solver))
    yielding.refuse(name + " on the implicit side, whose answer of the start serves for all windows", others);
  if (protocol.dual && on_explicit_side && on_explicit_side->substeps > 1)
    yielding.refuse(fmt::format("{} with {} substeps of \"{}\", whose answer of the start serves for all windows", name,
                                on_explicit_side->substeps, on_explicit_side->name),
                    "substeps = 1, or bodies that yield on the implicit side alone");
}

void check_contact_law(const Yielding& yielding) {
  const Scene& scene = yielding.problem.scene;
  if (scene.contacts.empty()) return;
  if (scene.massless_contact())
    yielding.refuse("with multiplier_update = \"massless\", which balances contact nodes by the stiffness of the start",
                    "\"trapezoidal_reset\" or, with an implicit side, \"fully_implicit\"");
  if (scene.contact_law().enforcement == Enforcement::penalty && yielding.owner(Role::implicit_solver))
    yielding.refuse("with enforcement = \"penalty\" on the implicit side", "enforcement = \"multiplier\"");
}

void check_ranks(const Yielding& yielding) {
  for (const ParticipantSpec& participant : yielding.problem.scene.participants)
    if (participant.ranks.value_or(1) > 1)
      yielding.refuse(fmt::format("with {} ranks of \"{}\"", *participant.ranks, participant.name),
                      "no ranks (and threads)");
}

}  // namespace

void check_plasticity(const Problem& problem) {
  for (const BodyProblem& body : problem.bodies) {
    if (!body.material.plasticity) continue;
    const Yielding yielding{problem, body};
    check_elements(yielding);
    check_protocol(yielding);
    check_contact_law(yielding);
    check_ranks(yielding);
  }
}

}  // namespace ricochet::scene
