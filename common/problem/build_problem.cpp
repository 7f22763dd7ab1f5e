#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numbers>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"
#include "common/problem/mass_scaling.hpp"
#include "common/problem/probes.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

fem::Section section_of(Model model, const Body& body) {
  switch (model) {
    case Model::bar: return {model, body.area_m2};
    case Model::plane_strain: return {model, body.thickness_m};
    case Model::axisymmetric: return {model, 2.0 * std::numbers::pi};
    case Model::solid: break;
  }
  return {model, 1.0};
}

BodyProblem build_body(const Scene& scene, const Body& spec) {
  BodyProblem body;
  body.name = spec.name;
  body.section = section_of(scene.model, spec);
  body.material = spec.material;
  body.mesh = build_mesh(scene, spec);
  if (spec.rigid)
    make_rigid(scene, spec, body);
  else
    scale_mass(scene, body);
  for (std::size_t i = 0; i < spec.tractions.size(); ++i)
    require_surface(scene, fmt::format("body.{}.traction[{}].surface", spec.name, i), body.mesh,
                    spec.tractions[i].surface);
  set_constraints(scene, spec, body);
  set_absorbing(scene, spec, body);
  set_initial_state(scene, spec, body);
  return body;
}

/// The scene's step, or safety_factor times the critical step of what is explicit. `all_implicit` takes the step that
/// `all_explicit` would take, so that the two can be compared.
void set_window_size(Problem& problem) {
  constexpr double largest_rough_share = 0.998;  // of a critical step that is known to 5e-4
  const Scene& scene = problem.scene;
  if (scene.time.step_s) {
    problem.clock = *scene.time.step_s;
    return;
  }
  const bool dual = scene.coupling.protocol.dual;
  double critical = std::numeric_limits<double>::infinity();
  for (const BodyProblem& body : problem.bodies) {
    const std::vector<bool> is_explicit = explicit_elements(problem, body);
    const double enough_s = critical_time_step(body, is_explicit, dual, 0.0);
    const bool close = scene.time.safety_factor > largest_rough_share;
    problem.critical_time_steps_s.push_back(close ? critical_time_step(body, is_explicit, dual, enough_s) : enough_s);
    critical = std::min(critical, scene.substeps(body.name).fewest * problem.critical_time_steps_s.back());
  }
  const double window = scene.time.safety_factor * critical;
  if (window > scene.time.end_s)
    throw ConfigError(fmt::format("{}: found {:.6g} s, shorter than one step of {:.6g} s; allowed: a later end",
                                  scene.where("time.end_s"), scene.time.end_s, window));
  problem.clock = window;
}

/// A step that is too long for every element would leave none explicit.
void bound_largest_step(Problem& problem) {
  Time& time = problem.scene.time;
  if (!time.largest_step_s) return;
  const std::vector<double> steps = element_critical_steps(problem);
  if (steps.empty()) return;  // all at the contact: refused with any step
  const double longest_s = time.safety_factor * *std::max_element(steps.begin(), steps.end());
  time.step_s = std::min(*time.step_s, problem.scene.substeps().most * longest_s);
}

/// With `coupling.substeps = "fewest"`: so many that a substep is at most safety_factor times the critical step of the
/// participant's own elements; 1 of a body that its program alone knows.
void find_fewest_substeps(Problem& problem) {
  for (ParticipantSpec& participant : problem.scene.participants) {
    if (participant.substeps > 0) continue;
    double critical_s = std::numeric_limits<double>::infinity();
    for (const BodyProblem& body : problem.bodies)
      critical_s =
          std::min(critical_s, critical_time_step(body, limiting_elements(problem, body, participant), true, 0.0));
    const double ratio = problem.clock.largest_size_s() / (problem.scene.time.safety_factor * critical_s);
    if (ratio > most_substeps)
      throw ConfigError(fmt::format(
          "{}: found \"fewest\", which is {:.4g} for participant \"{}\" of critical time step {:.6g} s; allowed: at "
          "most "
          "{}, by a shorter time.step_s or a larger implicit part",
          problem.scene.where("coupling.substeps"), std::ceil(ratio), participant.name, critical_s, most_substeps));
    participant.substeps = std::max(1, static_cast<int>(std::ceil(ratio)));
  }
}

/// Times from row to row become whole windows, the nearest number and at least one.
void count_windows_of_output(Problem& problem) {
  Output& output = problem.scene.output;
  const double size_s = problem.clock.largest_size_s();
  const auto count = [&](const std::optional<double>& every_s, int& every) {
    constexpr double most = std::numeric_limits<int>::max();
    if (every_s) every = static_cast<int>(std::min(most, std::max(1.0, std::round(*every_s / size_s))));
  };
  count(output.history_every_s, output.history_every);
  count(output.fields_every_s, output.fields_every);
  count(output.probes_every_s, output.probes_every);
}

}  // namespace

const fem::Material& material_at(const BodyProblem& body, const fem::Face& nodes) {
  if (body.mesh.material.empty()) return body.material;
  for (std::size_t e = 0; e < body.mesh.elements.size(); ++e) {
    const fem::Element& element = body.mesh.elements[e];
    if (std::all_of(nodes.begin(), nodes.end(),
                    [&](int node) { return std::find(element.begin(), element.end(), node) != element.end(); }))
      return fem::material_of(body, static_cast<int>(e));
  }
  return body.material;
}

const fem::Material& contact_material(const Problem& problem, const ContactGeometry& contact, int body) {
  const BodyProblem& of = problem.bodies[at(body)];
  return of.mesh.material.empty() ? of.material : material_at(of, {contact_nodes(contact, body).front()});
}

double fastest_wave_m_s(const BodyProblem& body) {
  double fastest = 0.0;
  for (const fem::Material* material : fem::materials_of(body))
    fastest = std::max(fastest, fem::longitudinal_wave_speed(body.section.model, *material));
  return fastest;
}

Problem build_bodies(const Scene& scene) {
  Problem problem;
  problem.scene = scene;
  for (const Body& body : scene.bodies) problem.bodies.push_back(build_body(scene, body));
  stiffen_rigid(problem);
  problem.joints = build_joints(scene, problem.bodies);
  problem.contacts = build_contacts(scene, problem.bodies);
  refuse_absorbing_contact(problem);
  bound_largest_step(problem);
  set_partition(problem);
  return problem;
}

Problem build_problem(const Scene& scene) {
  Problem problem = build_bodies(scene);
  set_window_size(problem);
  for (const StepChange& change : scene.time.changes)
    problem.clock.change(static_cast<std::int64_t>(problem.clock.window_at(change.from_s)), change.step_s);
  if (scene.time.flight_step_s) problem.clock.let_come(*scene.time.flight_step_s);
  problem.windows_of_scene = problem.clock.window_at(scene.time.end_s);
  find_fewest_substeps(problem);
  count_windows_of_output(problem);
  static_cast<void>(measured_places(problem));  // refuses what no body has
  return problem;
}

}  // namespace ricochet::scene
