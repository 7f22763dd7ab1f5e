#include "common/check/check_switch.hpp"

#include <fmt/format.h>

#include "common/problem/critical_step.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {

std::string switch_obstacle(const Problem& problem) {
  const Scene& scene = problem.scene;
  const bool asked = !scene.contacts.empty() && scene.coupling.after_separation == AfterSeparation::switch_to_explicit;
  if (!asked || !scene.coupling.protocol.may_switch) return "";
  for (const BodyProblem& body : problem.bodies) {
    const std::vector<bool> all(body.mesh.elements.size(), true);
    if (is_stable_step(body, all, problem.window_size_s)) continue;
    return fmt::format(
        "explicit and implicit elements of body \"{}\" together have a critical time step of {:.6g} s, below the "
        "step of {:.6g} s",
        body.name, critical_time_step(body, all, false, problem.window_size_s), problem.window_size_s);
  }
  return "";
}

}  // namespace ricochet::scene
