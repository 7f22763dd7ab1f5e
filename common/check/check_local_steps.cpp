#include "common/check/check_local_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"
#include "common/problem/local_steps.hpp"

namespace ricochet::scene {
namespace {

void refuse_absorbing(const Problem& problem, const BodyProblem& body, const fem::LocalSteps& steps) {
  const int components = fem::components(body.section.model);
  for (int node = 0; node < static_cast<int>(body.mesh.position.size()); ++node) {
    const bool absorbs = !body.damping_kg_s.segment(node * components, components).isZero(0.0);
    if (!absorbs || !steps.steps_locally(node)) continue;
    throw ConfigError(fmt::format(
        "{}: found the node of an absorbing surface of body \"{}\" at {} among elements that take several steps in a "
        "window of {:.6g} s; allowed with \"local_explicit\": a smaller step, or coarser elements there",
        problem.scene.where("time.step_s"), body.name, fem::place_text(body.mesh.model, body.mesh.position[at(node)]),
        problem.clock.size_s()));
  }
}

}  // namespace

LocalStepsPlan plan_local_steps(const Problem& problem, const ParticipantPart& part) {
  const BodyProblem& body = problem.bodies[at(part.body)];
  const fem::LocalSteps steps = local_steps(body, part.part, problem.clock.size_s());
  if (steps.any()) refuse_absorbing(problem, body, steps);
  return {body.name, steps.nodes_by_level(), extra_rows(problem, part.body, steps), steps.longest_window_s()};
}

void check_local_steps(const Problem& problem, Plan& plan) {
  if (!problem.scene.coupling.protocol.local_steps) return;
  double longest_s = 0.0;
  for (const LocalStepsPlan& body : plan.local_steps) {
    longest_s = std::max(longest_s, body.longest_window_s);
    std::string nodes;
    for (std::size_t level = 0; level < body.nodes.size(); ++level)
      nodes += fmt::format("{}{} take {}", level == 0 ? "" : ", ", body.nodes[level], 1LL << level);
    if (body.nodes.size() > 1)
      plan.notes.push_back(fmt::format(
          "local steps of body \"{}\": of {} nodes {}; a window costs {:.3g} products "
          "with all of its stiffness",
          body.body, std::accumulate(body.nodes.begin(), body.nodes.end(), 0), nodes, 1.0 + body.extra_rows));
  }
  const double step_s = problem.clock.size_s();
  if (step_s > longest_s)
    throw ConfigError(fmt::format(
        "{}: found {:.6g} s, too long for every element; allowed with \"local_explicit\": {:.3g} or less, a step that "
        "the coarse elements take",
        problem.scene.where("time.step_s"), step_s, longest_s));
}

}  // namespace ricochet::scene
