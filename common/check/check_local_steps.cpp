#include "common/check/check_local_steps.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"
#include "common/problem/given_motion.hpp"
#include "common/problem/local_steps.hpp"

namespace ricochet::scene {
namespace {

/// A jump by a smaller share of the largest velocity is that of a ramp in pieces.
constexpr double told_jump = 0.2;
/// The share that is granted of the longest window found: levels of another one are scaled anew.
constexpr double takes = 0.9;

void refuse_absorbing(const Problem& problem, const ParticipantPart& part, const fem::LocalSteps& steps) {
  const BodyProblem& body = problem.bodies[at(part.body)];
  const int components = fem::components(body.section.model);
  for (int i = 0; i < part.part.nodes(); ++i) {
    const int node = part.part.body_node[at(i)];
    const bool absorbs = !body.damping_kg_s.segment(node * components, components).isZero(0.0);
    if (!absorbs || !steps.steps_locally(i)) continue;
    throw ConfigError(fmt::format(
        "{}: found the node of an absorbing surface of body \"{}\" at {} among elements that take several steps in a "
        "window of {:.6g} s; allowed with \"local_explicit\": a smaller step, or coarser elements there",
        problem.scene.where("time.step_s"), body.name, fem::place_text(body.mesh.model, body.mesh.position[at(node)]),
        problem.clock.size_s()));
  }
}

/// Small steps are those of the frame of a body that turns: a direction that is held in space stays one of the frame's
/// only where a plane of nodes is held along its normal.
void refuse_half_held(const Problem& problem, const ParticipantPart& part) {
  const BodyProblem& body = problem.bodies[at(part.body)];
  const int components = fem::components(body.section.model);
  std::optional<int> normal;
  Eigen::AlignedBox3d box;
  int where = -1;
  bool plane = components == 3;
  for (int i = 0; i < part.part.nodes(); ++i) {
    const int node = part.part.body_node[at(i)];
    const auto first = body.fixed_dof.begin() + node * components, end = first + components;
    const auto held = std::count(first, end, true);
    if (held == 0 || held == components) continue;
    const auto along = static_cast<int>(std::find(first, end, true) - first);
    plane = plane && held == 1 && normal.value_or(along) == along;
    normal = along;
    where = node;
    box.extend(body.mesh.position[at(node)]);
  }
  if (!normal) return;
  for (int c = 0; c < components; ++c) plane = plane && (c == *normal || box.sizes()[c] > 0.0);
  if (plane) return;
  throw ConfigError(fmt::format(
      "{}: found large_rotation of a body whose node at {} is held in some directions, among elements that take "
      "several steps in a window; allowed: a smaller step, supports in all directions, or one plane of nodes held "
      "along its normal",
      problem.scene.where("body." + body.name + ".large_rotation"),
      fem::place_text(body.mesh.model, body.mesh.position[at(where)])));
}

/// Velocities of a piecewise linear motion up to `end_s`: before its first time v_0, then of each piece, then 0 [m/s].
std::vector<double> velocities(const Amplitude& amplitude, double displacement_m, double v_0, double end_s) {
  const auto& time_s = amplitude.time_s;
  std::vector<double> found{v_0};
  for (std::size_t i = 0; i < time_s.size() && time_s[i] < end_s; ++i) {
    const bool last = i + 1 == time_s.size();
    const double factors = last ? 0.0 : amplitude.factor[i + 1] - amplitude.factor[i];
    found.push_back(last ? 0.0 : displacement_m * factors / (time_s[i + 1] - time_s[i]));
  }
  if (time_s.empty()) found.push_back(0.0);  // held from the start on
  return found;
}

/// Held nodes among small steps move from one window to the next: elements of theirs take a velocity that jumps as a
/// blow, and ring.
std::string jump_among_small_steps(const Problem& problem, const ParticipantPart& part, const fem::LocalSteps& steps) {
  const BodyProblem& body = problem.bodies[at(part.body)];
  const Body& spec = problem.scene.bodies[at(part.body)];
  const int components = fem::components(body.section.model);
  const Eigen::VectorXd& v = body.initial_velocity_m_s;
  double fastest = v.cwiseAbs().maxCoeff(), largest = 0.0;
  int where = 0;
  const auto of_body = [&](Eigen::Index dof) {
    return part.part.body_node[at(static_cast<int>(dof) / components)] * components +
           static_cast<int>(dof) % components;
  };
  for (int i = 0; i < part.part.dofs(); ++i) {
    const int dof = of_body(i), node = dof / components;
    if (!body.fixed_dof[at(dof)] || !steps.steps_locally(i / components)) continue;
    double jump = 0.0, around = 0.0;
    for (fem::SparseMatrix::InnerIterator it(part.part.stiffness, i); it; ++it)
      if (const int other = of_body(it.col()); other % components == dof % components)
        if (std::abs(v[other]) > std::abs(around)) around = v[other];
    const GivenMotion motion = is_still(body, dof) ? GivenMotion{} : given_motion(spec, body, dof);
    const Amplitude still;
    const auto add = [&](const Amplitude& amplitude, double displacement_m) {
      const std::vector<double> own = velocities(amplitude, displacement_m, around, problem.scene.time.end_s);
      for (std::size_t k = 0; k + 1 < own.size(); ++k) jump = std::max(jump, std::abs(own[k + 1] - own[k]));
      for (const double speed : own) fastest = std::max(fastest, std::abs(speed));
    };
    if (motion.along != nullptr || !motion.moves())
      add(motion.along != nullptr ? *motion.along : still, motion.displacement_m);
    if (motion.turn != nullptr) add(*motion.turn, motion.angle_rad * motion.across_m);
    if (jump <= largest) continue;
    largest = jump;
    where = node;
  }
  if (largest <= told_jump * fastest) return "";
  return fmt::format(
      "the velocity of body \"{}\" jumps by {:.3g} m/s at the held node at {}, among elements that take several steps "
      "in a window: their stress rings; let the motion grow over some windows, or make these elements coarser",
      body.name, largest, fem::place_text(body.mesh.model, body.mesh.position[at(where)]));
}

}  // namespace

LocalStepsPlan plan_local_steps(const Problem& problem, const ParticipantPart& part) {
  const BodyProblem& body = problem.bodies[at(part.body)];
  const fem::LocalSteps steps = [&] {
    try {
      return local_steps(problem, part.body, part.part, part.shared, problem.clock.size_s());
    } catch (const SolverError& error) {
      throw ConfigError(fmt::format(
          "{}: found {:.6g} s, in which elements of body \"{}\" take no small steps: {}; allowed: a smaller step{}",
          problem.scene.where("time.step_s"), problem.clock.size_s(), body.name, error.what(),
          problem.scene.coupling.protocol.coupled() ? ", or partition.implicit_length_m in place of rule = \"auto\""
                                                    : ""));
    }
  }();
  if (steps.any()) refuse_absorbing(problem, part, steps);
  if (steps.any() && problem.scene.bodies[at(part.body)].large_rotation) refuse_half_held(problem, part);
  const bool with_contact = !problem.scene.coupling.protocol.coupled();  // else the implicit side has it
  return {body.name, steps.nodes_by_level(), with_contact ? extra_rows(problem, part.body, steps) : steps.extra_rows(),
          steps.longest_window_s(), jump_among_small_steps(problem, part, steps)};
}

void check_local_steps(const Problem& problem, Plan& plan) {
  double longest_s = 0.0;
  for (const LocalStepsPlan& body : plan.local_steps) {
    longest_s = std::max(longest_s, body.longest_window_s);
    if (!body.jump.empty()) plan.warnings.push_back(body.jump);
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
  if (problem.scene.coupling.protocol.local_steps && step_s > longest_s)
    throw ConfigError(fmt::format(
        "{}: found {:.6g} s, too long for every element; allowed with \"local_explicit\": {:.3g} or less, a step that "
        "the coarse elements take",
        problem.scene.where("time.step_s"), step_s, takes * longest_s));
}

}  // namespace ricochet::scene
