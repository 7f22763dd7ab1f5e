#include "common/solver/describe.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/fem/vtk_output.hpp"
#include "common/problem/critical_step.hpp"
#include "common/solver/contact_record.hpp"

namespace ricochet::solver {
namespace {

/// Of the participant's elements, 0 without any. (The switch to all-explicit makes the implicit participant integrate
/// its elements that way, too.)
double critical_time_step(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                          const std::vector<BodyState>& states) {
  std::vector<scene::AssembledPart> parts;
  for (const auto& state : states) parts.push_back({state.body, &state.part});
  const double step_s = scene::critical_time_step(problem, participant, parts, 0.0);
  return std::isfinite(step_s) ? step_s : 0.0;
}

}  // namespace

participant::Description describe(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                                  const std::vector<BodyState>& states, bool contact_owner) {
  participant::Description d;
  d.name = participant.name;
  d.role = participant.role;
  d.solver_version = RICOCHET_VERSION;
  d.scene_sha256 = problem.scene.sha256;
  d.components = problem.scene.components();
  d.contact_owner = contact_owner;
  d.critical_time_step_s = critical_time_step(problem, participant, states);
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

void take_interface_mass(const std::vector<double>& interface_mass_kg, std::vector<BodyState>& states) {
  std::size_t next = 0;
  for (auto& state : states) {
    Eigen::VectorXd node_mass = state.part.lumped_mass;
    for (const int node : state.shared_nodes) node_mass[node] = interface_mass_kg[next++];
    state.set_mass(node_mass);
  }
}

void record_bodies(const std::vector<BodyState>& states, std::vector<double>& row) {
  for (const auto& state : states) append_quantities(state.totals, row);
}

void write_fields(const std::string& directory, const std::string& participant, std::int64_t window,
                  const std::vector<BodyState>& states) {
  std::vector<const fem::Part*> parts;
  std::vector<const Eigen::VectorXd*> displacement, velocity;
  for (const auto& state : states) {
    parts.push_back(&state.part);
    displacement.push_back(&state.u);
    velocity.push_back(&state.v);
  }
  fem::write_vtu(fmt::format("{}/{}_{:08}.vtu", directory, participant, window), parts, displacement, velocity);
}

}  // namespace ricochet::solver
