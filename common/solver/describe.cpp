#include "common/solver/describe.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/contact/contact_record.hpp"
#include "common/fem/vtk_output.hpp"
#include "common/problem/critical_step.hpp"

namespace ricochet::solver {
namespace {

/// That of the participant's elements, 0 without any. (After the switch to all-explicit the implicit one integrates
/// its elements that way, too.)
double found_critical_step(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                           const std::vector<BodyState>& states) {
  std::vector<scene::AssembledPart> parts;
  for (const auto& state : states) parts.push_back({state.body, &state.part});
  const double step_s = scene::critical_time_step(problem, participant, parts, 0.0);
  return std::isfinite(step_s) ? step_s : 0.0;
}

/// To find it takes some hundred products with K and has been done by who tells it. A few products show that it is not
/// that of another mesh or material, and too long: one that is too short does no harm.
double checked_critical_step(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                             const std::vector<BodyState>& states, double told_s) {
  constexpr double found_roughly = 1e-3;  // in large bodies, and then from above
  if (participant.role == scene::Role::implicit_solver) return told_s;
  const double longest_s = told_s > 0.0 ? told_s : std::numeric_limits<double>::infinity();
  for (const auto& state : states) {
    const auto& body = problem.bodies[static_cast<std::size_t>(state.body)];
    if (!body.small_steps.empty()) continue;
    const double largest_s =
        scene::largest_critical_time_step(body, state.part, state.stiffness, problem.scene.coupling.protocol.dual);
    if (!std::isfinite(largest_s) || longest_s <= (1.0 + found_roughly) * largest_s) continue;
    throw ConfigError(fmt::format(
        "participant '{}' was told the critical time step {:.6g} s (--critical-step), its elements of body '{}' have "
        "at most {:.6g} s; start it by the coupler that runs this scene, or without --critical-step",
        participant.name, told_s, state.name, largest_s));
  }
  return told_s;
}

}  // namespace

participant::Description describe(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                                  const std::vector<BodyState>& states, bool contact_owner,
                                  std::optional<double> told_critical_step_s) {
  participant::Description d;
  d.name = participant.name;
  d.role = participant.role;
  d.solver_version = RICOCHET_VERSION;
  d.scene_sha256 = problem.scene.sha256;
  d.components = problem.scene.components();
  d.contact_owner = contact_owner;
  // Modes bear any window.
  d.critical_time_step_s = participant.reduced ? 0.0
                           : told_critical_step_s
                               ? checked_critical_step(problem, participant, states, *told_critical_step_s)
                               : found_critical_step(problem, participant, states);
  for (std::size_t b = 0; b < states.size(); ++b) {
    const auto& state = states[b];
    d.bodies.push_back(state.name);
    for (const int node : state.shared_nodes) {
      d.interface_body.push_back(static_cast<int>(b));
      const auto& x = state.part.mesh.position[static_cast<std::size_t>(node)];
      for (int c = 0; c < d.components; ++c) d.interface_position_m.push_back(x[c]);
      d.interface_mass_kg.push_back(state.part.lumped_mass[node]);
    }
    for (const auto& quantity : body_quantities)
      d.record_columns.push_back(fmt::format("{}/{}", quantity.first, state.name));
    if (participant.reduced)
      for (const auto& quantity : reduced_quantities)
        d.record_columns.push_back(fmt::format("{}/{}", quantity.first, state.name));
    if (!state.plastic) continue;
    for (const auto& quantity : plastic_quantities)
      if (quantity.second != &BodyTotals::temperature_max_k || state.plastic->heats())
        d.record_columns.push_back(fmt::format("{}/{}", quantity.first, state.name));
  }
  if (contact_owner) {
    for (const auto& quantity : contact_quantities) d.record_columns.emplace_back(quantity.first);
    for (const auto& contact : problem.scene.contact_names()) {
      for (const auto& quantity : named_contact_quantities)
        d.record_columns.push_back(fmt::format("{}/{}", quantity.first, contact));
    }
  }
  return d;
}

void record_bodies(const std::vector<BodyState>& states, std::vector<double>& row) {
  for (const auto& state : states) {
    append_quantities(state.totals, row);
    if (!state.plastic) continue;
    row.push_back(state.plastic->work_j.sum());
    row.push_back(state.plastic->largest);
    if (state.plastic->heats()) row.push_back(state.plastic->hottest_k);
  }
}

namespace {

fem::PlasticStrain plastic_strain(const BodyState& state) {
  const auto elements = static_cast<int>(state.part.mesh.elements.size());
  fem::PlasticStrain plastic{Eigen::MatrixXd(state.plastic->components, elements), Eigen::VectorXd(elements),
                             Eigen::VectorXd(state.plastic->heats() ? elements : 0)};
  for (int e = 0; e < elements; ++e) {
    plastic.stress_pa.col(e) = state.plastic->stress_of(e);
    plastic.equivalent[e] = state.plastic->equivalent_of(e);
    if (state.plastic->heats()) plastic.temperature_k[e] = state.plastic->temperature_of(e);
  }
  return plastic;
}

}  // namespace

void write_fields(const std::string& directory, const std::string& participant, std::int64_t window,
                  const std::vector<BodyState>& states, const std::vector<fem::ContactFields>& contact,
                  bool moved_by_link) {
  for (std::size_t b = 0; b < states.size(); ++b) {
    const auto& state = states[b];
    Eigen::VectorXd acceleration = state.a;
    for (const int dof : state.shared_dofs)
      if (moved_by_link) acceleration[dof] = std::numeric_limits<double>::quiet_NaN();
    fem::PartFields part{&state.part, &state.u, &state.v, &acceleration};
    part.body = state.body;
    fem::PlasticStrain plastic;
    if (state.plastic) part.plastic = &(plastic = plastic_strain(state));
    Eigen::VectorXd straining;
    if (state.frame) {
      part.straining = &(straining = state.frame->straining(state.u));
      part.rotation = state.rotation();
    }
    fem::write_vtu(fmt::format("{}/{}.{}_{:08}.vtu", directory, participant, state.name, window), part,
                   contact.empty() ? nullptr : &contact[b]);
  }
}

}  // namespace ricochet::solver
