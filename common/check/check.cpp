#include "common/check/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/check/check_bodies.hpp"
#include "common/check/check_contact.hpp"
#include "common/check/check_islands.hpp"
#include "common/check/check_local_steps.hpp"
#include "common/check/check_mass_scaling.hpp"
#include "common/check/check_model.hpp"
#include "common/check/check_nonlinear.hpp"
#include "common/check/check_reach.hpp"
#include "common/check/check_switch.hpp"
#include "common/problem/build.hpp"
#include "common/problem/critical_step.hpp"
#include "common/scene/protocols.hpp"

namespace ricochet::scene {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// Share of the critical step above which the shortest wave of the mesh grows once a contact has released it: at
/// Courant 1 linearly; in a hybrid earlier, since what the implicit side sends at every impact the explicit side keeps.
/// Measured, docs/limits.md.
constexpr double largest_quiet_share = 0.999, largest_quiet_share_hybrid = 0.95;
constexpr double poisson_locking = 0.49;
/// Beyond it the number of a step is no integer in a double, in which history rows carry it.
constexpr double most_windows = 1e15;

int count_unknowns(const Problem& problem, const ParticipantPart& part, bool implicit) {
  const int components = problem.scene.components();
  const BodyProblem& body = problem.bodies[at(part.body)];
  int free = 0;
  for (int node = 0; node < part.part.nodes(); ++node) {
    const bool shared = std::binary_search(part.shared.begin(), part.shared.end(), node);
    if (!implicit && shared && !problem.scene.coupling.protocol.dual) continue;
    for (int c = 0; c < components; ++c)
      if (!body.fixed_dof[at(part.part.body_node[at(node)] * components + c)]) ++free;
  }
  return free;
}

/// Refuses more than leave the shared unknowns a flexibility of their own.
int count_modes(const Problem& problem, const std::vector<ParticipantPart>& parts) {
  int all = 0;
  for (const ParticipantPart& part : parts) {
    const std::string& body = problem.bodies[at(part.body)].name;
    const int modes = problem.scene.partition.reduced_modes.at(body), free = count_unknowns(problem, part, true);
    const int shared = static_cast<int>(part.shared.size()) * problem.scene.components();
    if (shared == 0)
      throw ConfigError(
          fmt::format("{}: found a body without implicit elements; allowed: bodies with some, which move its modes",
                      problem.scene.where("partition.reduced_modes." + body)));
    if (modes + shared > free)
      throw ConfigError(
          fmt::format("{}: found {}; allowed: at most {}, of {} degrees of freedom less the {} that are shared",
                      problem.scene.where("partition.reduced_modes." + body), modes, free - shared, free, shared));
    all += modes;
  }
  return all;
}

/// `local_steps`: of its parts that take some, where somebody asks.
ParticipantPlan plan_participant(const Problem& problem, const ParticipantSpec& participant,
                                 std::vector<LocalStepsPlan>* local_steps) {
  const bool implicit = participant.role == Role::implicit_solver;
  ParticipantPlan plan;
  plan.name = participant.name;
  plan.role = participant.role;
  plan.critical_time_step_s = infinity;
  const std::vector<ParticipantPart> parts = participant_parts(problem, participant);
  std::vector<AssembledPart> assembled;
  for (const ParticipantPart& part : parts) {
    plan.nodes += part.part.nodes();
    plan.elements += static_cast<int>(part.part.mesh.elements.size());
    plan.interface_nodes += static_cast<int>(part.shared.size());
    plan.unknowns += count_unknowns(problem, part, implicit);
    assembled.push_back({part.body, &part.part});
    if (!implicit && local_steps != nullptr && !problem.bodies[at(part.body)].small_steps.empty())
      local_steps->push_back(plan_local_steps(problem, part));
  }
  for (const Joint& joint : problem.joints)
    if (std::find(participant.bodies.begin(), participant.bodies.end(), joint.foreign) != participant.bodies.end())
      plan.interface_nodes += static_cast<int>(joint.nodes.size());
  if (implicit && plan.unknowns == 0)
    throw ConfigError(
        fmt::format("{}: found nothing that moves freely on the implicit side: all of its nodes are held; "
                    "allowed: a free node there, or protocol \"all_explicit\"",
                    problem.scene.where("partition")));
  if (participant.reduced) plan.unknowns = count_modes(problem, parts);
  if (!implicit)
    plan.critical_time_step_s =
        critical_time_step(problem, participant, assembled, problem.clock.largest_size_s() / participant.substeps);
  return plan;
}

/// Whether it is the longer windows of a flight that elements have to bear.
bool flight_is_longest(const Problem& problem) {
  return problem.scene.time.flight_step_s && problem.clock.largest_size_s() > problem.clock.size_s(1);
}

/// "time.step_s", or "time" if the step follows from the safety factor, or where a longer one comes later.
std::string step_place(const Problem& problem) {
  const Scene& scene = problem.scene;
  if (problem.clock.largest_size_s() > problem.clock.size_s(1))
    return scene.where(std::string("time.") + scene.time.key_of_sizes());
  return scene.where(scene.time.largest_step_s ? "time.largest_step_s" : scene.time.step_s ? "time.step_s" : "time");
}

void check_critical_step(const Problem& problem, const ParticipantPlan& participant,
                         std::vector<std::string>& warnings) {
  const ProtocolTraits& protocol = problem.scene.coupling.protocol;
  const int substeps = problem.scene.participant(participant.name).substeps;
  const bool flight = flight_is_longest(problem);
  const char* const key = flight ? "flight_step_s" : "step_s";
  const double critical = participant.critical_time_step_s;
  const double step = problem.clock.largest_size_s() / substeps, ratio = step / critical;
  if (ratio > 1.0 + 1e-9)
    throw ConfigError(fmt::format(
        "{}: found a step of {:.6g} s, {:.4g} times the critical time step {:.6g} s of participant \"{}\"; allowed: "
        "{} = {:.3g} or less, {}or a larger implicit part",
        step_place(problem), step, ratio, critical, participant.name, key, 0.9 * substeps * critical,
        protocol.own_substeps ? fmt::format("substeps = {} of that participant, ", std::ceil(substeps * ratio / 0.9))
        : protocol.dual       ? "more coupling.substeps, "
                              : ""));
  const bool hybrid = protocol.layout == Layout::hybrid;
  if (ratio > (hybrid ? largest_quiet_share_hybrid : largest_quiet_share))
    warnings.push_back(
        fmt::format("the step is {:.5g} times the critical time step of \"{}\": the shortest wave of the mesh may grow "
                    "from impact to "
                    "impact{}; {} = {:.3g} leaves room",
                    ratio, participant.name, flight ? ", and energy change at the end of a flight" : "", key,
                    0.9 * substeps * critical));
}

/// Steps up to the latest end; if they have two sizes, as if all were short.
long long count_windows(const Problem& problem) {
  const Time& time = problem.scene.time;
  const double windows = (time.flight_step_s ? WindowClock(*time.step_s) : problem.clock).window_at(time.end_s);
  if (!(windows <= most_windows))
    throw ConfigError(fmt::format(
        "{}: found {:.6g} s, which takes {:.3g} steps of {:.6g} s; allowed: an end after at most {:g} steps",
        problem.scene.where("time.end_s"), problem.scene.time.end_s, windows, problem.clock.size_s(), most_windows));
  return static_cast<long long>(windows);
}

void check_materials(const Problem& problem, std::vector<std::string>& warnings) {
  if (problem.scene.model == Model::bar) return;
  for (const BodyProblem& body : problem.bodies)
    for (const fem::Material* material : fem::materials_of(body))
      if (material->poisson_ratio > poisson_locking)
        warnings.push_back(fmt::format(
            "body \"{}\": poisson_ratio = {} is nearly incompressible: elements lock and the wave speed, {:.4g} m/s, "
            "asks for small steps",
            body.name, material->poisson_ratio, fem::longitudinal_wave_speed(problem.scene.model, *material)));
}

/// Its extent along x, y, z, or r and z.
std::string extent_text(Model model, const Eigen::Vector3d& extent_m) {
  if (model == Model::bar) return fmt::format("{:.4g}", extent_m[0]);
  if (model == Model::axisymmetric) return fmt::format("r {:.4g}, z {:.4g}", extent_m[0], extent_m[1]);
  if (model == Model::plane_strain) return fmt::format("{:.4g} x {:.4g}", extent_m[0], extent_m[1]);
  return fmt::format("{:.4g} x {:.4g} x {:.4g}", extent_m[0], extent_m[1], extent_m[2]);
}

std::string body_rows(Model model, const Plan& plan) {
  std::string text = fmt::format("{:<16} {:>24} {:>12} {:>12} {:>12} {:>12}\n", "body", "extent [m]", "volume [m^3]",
                                 "mass [kg]", "speed [m/s]", "energy [J]");
  for (const BodyPlan& body : plan.bodies)
    text += fmt::format("{:<16} {:>24} {:>12.4g} {:>12.4g} {:>12.4g} {:>12.4g}{}\n", body.name,
                        extent_text(model, body.extent_m), body.volume_m3, body.mass_kg, body.speed_m_s, body.energy_j,
                        body.rigid ? "  rigid" : "");
  return text;
}

}  // namespace

std::vector<ParticipantPlan> plan_participants(const Problem& problem, std::vector<LocalStepsPlan>* local_steps) {
  std::vector<ParticipantPlan> plans;
  for (const ParticipantSpec& participant : problem.scene.participants)
    plans.push_back(plan_participant(problem, participant, local_steps));
  return plans;
}

double element_bound_time_step(const Problem& problem, const ParticipantSpec& participant) {
  double smallest = infinity;
  for (const BodyProblem& body : problem.bodies) {
    const std::vector<bool> owned = owned_elements(problem.scene, body, participant);
    const bool any = std::find(owned.begin(), owned.end(), true) != owned.end();
    if (participant.role == Role::implicit_solver || !any || !body.small_steps.empty()) continue;
    smallest = std::min(smallest, element_bound_time_step(body, limiting_elements(problem, body, participant)));
  }
  return smallest;
}

double critical_time_step(const std::vector<ParticipantPlan>& participants) {
  double smallest = infinity;
  for (const ParticipantPlan& participant : participants)
    smallest = std::min(smallest, participant.critical_time_step_s);
  return smallest;
}

Plan plan(const Problem& problem) {
  const Scene& scene = problem.scene;
  Plan plan;
  plan.windows = count_windows(problem);
  check_nonlinear(problem);
  for (const ContactGeometry& contact : problem.contacts) plan.contact_pairs += static_cast<int>(contact.pairs.size());
  const ProtocolTraits& protocol = scene.coupling.protocol;
  const bool one_step = protocol.dual && scene.substeps().most == 1;  // then dual protocols do not differ
  if (!protocol.warning.empty() && !one_step) plan.warnings.push_back(protocol.warning);
  plan.participants = plan_participants(problem, &plan.local_steps);
  for (const ParticipantPlan& participant : plan.participants) check_critical_step(problem, participant, plan.warnings);
  plan.bodies = plan_bodies(problem);
  check_units(problem, plan);
  check_materials(problem, plan.warnings);
  check_penalty(problem, plan);
  check_supports(problem);
  check_friction(problem, plan);
  check_impact(problem, plan);
  check_overlaps(problem, plan);
  check_slip_in_flight(problem, plan);
  plan.notes = unreached_ends(problem);
  note_ignored_cards(scene, plan);
  note_partial_ties(problem, plan);
  check_local_steps(problem, plan);
  check_mass_scaling(problem, plan);
  for (const Joint& joint : problem.joints)
    plan.notes.push_back(fmt::format(
        "\"{}\" is foreign: joined to \"{}\" at {} node{}; its elements and its critical time step are known to its "
        "participant alone",
        joint.foreign, problem.bodies[at(joint.body)].name, joint.nodes.size(), joint.nodes.size() == 1 ? "" : "s"));
  for (const ParticipantSpec& participant : scene.participants)
    if (participant.role == Role::explicit_solver && participant.substeps > 1)
      plan.notes.push_back(fmt::format("participant \"{}\" takes {} substeps of {:.6g} s in a window", participant.name,
                                       participant.substeps, problem.clock.largest_size_s() / participant.substeps));
  plan.switch_obstacle = switch_obstacle(problem);
  if (!plan.switch_obstacle.empty())
    plan.notes.push_back("the implicit side stays implicit after separation: " + plan.switch_obstacle);
  for (const auto& participant : scene.participants) {
    if (!scene.checkpoint.asked || participant.executable.empty()) continue;
    plan.notes.push_back(fmt::format(
        "checkpoints need the capability \"save_state\" of participant '{}'; `{} check-participant` tells whether "
        "{} has it",
        participant.name, command_name, participant.executable));
  }
  return plan;
}

std::string to_text(const Problem& problem, const Plan& plan) {
  std::string text = fmt::format("{:<16} {:<9} {:>8} {:>9} {:>9} {:>10} {:>18}\n", "participant", "role", "nodes",
                                 "elements", "unknowns", "interface", "critical step [s]");
  for (const ParticipantPlan& p : plan.participants) {
    const bool local = p.role == Role::explicit_solver && p.elements > 0 && !plan.local_steps.empty();
    const std::string critical = std::isfinite(p.critical_time_step_s) ? fmt::format("{:.6g}", p.critical_time_step_s)
                                 : local                               ? "local"
                                                                       : "none";
    text += fmt::format("{:<16} {:<9} {:>8} {:>9} {:>9} {:>10} {:>18}\n", p.name, name_of(p.role), p.nodes, p.elements,
                        p.unknowns, p.interface_nodes, critical);
  }
  text += body_rows(problem.scene.model, plan);
  const auto& flight = problem.scene.time.flight_step_s;
  text += fmt::format("step {:.6g} s{}, at most {} steps, {} contact pairs\n", problem.clock.size_s(1),
                      flight ? fmt::format(", in flight {:.6g} s", *flight) : "", plan.windows, plan.contact_pairs);
  if (plan.penalty_step_ratio > 0.0)
    text += fmt::format("penalty: sqrt(2 alpha_n/m) dt = {:.4g}, alpha_n/k = {:.4g}\n", plan.penalty_step_ratio,
                        plan.penalty_stiffness_ratio);
  if (plan.penalty_delay_s > 0.0)
    text += fmt::format("penalty: contact lasts about {:.4g} s too long (1.678 tau)\n", plan.penalty_delay_s);
  if (plan.penalty_critical_s > 0.0)
    text += fmt::format("penalty: critical step in contact {:.6g} s\n", plan.penalty_critical_s);
  for (const std::string& warning : plan.warnings) text += "warning: " + warning + "\n";
  for (const std::string& note : plan.notes) text += "note: " + note + "\n";
  for (const auto& islands : islands_of(problem)) text += "note: " + text_of(problem, islands) + "\n";
  return text;
}

}  // namespace ricochet::scene
