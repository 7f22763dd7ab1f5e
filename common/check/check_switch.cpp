#include "common/check/check_switch.hpp"

#include <fmt/format.h>

#include "common/problem/critical_step.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {

bool is_to_switch(const Problem& problem) {
  const auto& coupling = problem.scene.coupling;
  return !problem.scene.contacts.empty() && coupling.after_separation == AfterSeparation::switch_to_explicit &&
         coupling.protocol.may_switch;
}

std::string switch_obstacle(const Problem& problem) {
  if (!is_to_switch(problem)) return "";
  for (const BodyProblem& body : problem.bodies) {
    const std::vector<bool> all(body.mesh.elements.size(), true);
    if (is_stable_step(body, all, problem.clock.largest_size_s())) continue;
    return fmt::format(
        "explicit and implicit elements of body \"{}\" together have a critical time step of {:.6g} s, below the "
        "step of {:.6g} s",
        body.name, critical_time_step(body, all, false, problem.clock.largest_size_s()),
        problem.clock.largest_size_s());
  }
  return "";
}

}  // namespace ricochet::scene
