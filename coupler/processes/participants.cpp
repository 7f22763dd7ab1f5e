#include "coupler/processes/participants.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/error.hpp"
#include "common/base/parallel.hpp"
#include "common/wire/codec.hpp"
#include "coupler/processes/executable.hpp"
#include "coupler/processes/run_id.hpp"
#include "coupler/watch/energy_watch.hpp"

namespace ricochet::coupler {
namespace {

Member member_of(const scene::Scene& scene, const scene::ParticipantSpec& participant, const std::string& executable,
                 const ResultsDirectory& results) {
  const auto& name = participant.name;
  const auto key_file = results.file("keys/" + name + ".key");
  Member member{name, participant.role, executable, {"--scene", scene.path, "--name", name}};
  if (participant.start == scene::Start::by_hand) {
    member.executable = participant.executable.empty() ? shipped_program(participant) : participant.executable;
    member.key_file = key_file;
  } else {
    member.arguments.emplace_back("--watch-stdin");
    member.log_path = results.log(name);
    if (auto words = launch_prefix(scene, participant); !words.empty()) {
      words.push_back(executable);
      member.arguments.insert(member.arguments.begin(), words.begin() + 1, words.end());
      member.executable = words.front();
      member.key_file = key_file;
    }
  }
  return member;
}

/// Two hand-overs a window less are worth more than a processor that is not there. A scene that names a transport
/// wants processes.
bool pays_inside(const scene::Scene& scene, const scene::ParticipantSpec& participant) {
  const auto processes = static_cast<int>(scene.participants.size()) + 1;
  return make_inside() && scene.coupling.protocol.coupled() && participant.role == Role::implicit_solver &&
         !participant.foreign() && participant.start == scene::Start::launch &&
         launch_prefix(scene, participant).empty() && scene.coupling.transport == Transport::automatic &&
         usable_processors() < processes;
}

/// Largest message that participants of this scene can have to send [bytes]; how much a foreign body has is not known.
std::size_t largest_message(const scene::Problem& problem) {
  if (!problem.joints.empty()) return wire::max_message_bytes;
  // Per node three components of a few arrays, or two numbers each of a state for displacement and velocity; history
  // rows of as many windows as a baseline computes at once.
  constexpr std::size_t least = std::size_t{1} << 22, per_node = 64 * sizeof(double),
                        per_body = 4200 * 20 * sizeof(double);
  std::size_t nodes = 0;
  for (const auto& body : problem.bodies) nodes += body.mesh.position.size();
  return std::min(wire::max_message_bytes, least + per_body * problem.bodies.size() + per_node * nodes);
}

}  // namespace

ProtocolSettings protocol_settings(const scene::CouplingSettings& coupling) {
  return {coupling.substeps, coupling.acceleration, coupling.relaxation, coupling.tolerance, coupling.max_iterations};
}

wire::Array directions_along(const Eigen::Vector3d& normal, int components) {
  const Eigen::Vector3d tangent = scene::tangent_of(normal), binormal = normal.cross(tangent);
  wire::Array directions;
  directions.resize(components, components);
  auto out = directions.data.begin();
  for (const auto* direction : {&normal, &tangent, &binormal}) {
    if (out != directions.data.end()) out = std::copy_n(direction->data(), components, out);
  }
  return directions;
}

wire::Initialize initialize_request(const scene::Problem& problem, std::int64_t last_window,
                                    const std::string& output_directory) {
  const auto& scene = problem.scene;
  wire::Initialize request;
  request.window_size_s = problem.clock.size_s(1);
  request.directions = directions_along(scene::momentum_normal(problem), scene.components());
  request.output_directory = output_directory;
  request.protocol = scene.coupling.protocol.name;
  request.substeps = scene.coupling.substeps;
  request.history_every = std::gcd(static_cast<std::int64_t>(scene.output.history_every),
                                   EnergyWatch::every_of(problem.windows_of_scene));  // for both
  request.fields_every = scene.output.fields_every;
  request.axial_stress_every = scene.output.axial_stress_every;
  request.probes_every = scene.output.probes_told_every();
  request.until_separated_plus_s = scene.time.until_separated_plus_s.value_or(-1.0);
  request.separation_windows = scene.coupling.separation_windows;
  request.last_window = last_window;
  return request;
}

std::vector<std::string> find_executables(const scene::Scene& scene) {
  std::vector<std::string> paths;
  for (const auto& participant : scene.participants) {
    const bool launched = participant.start == scene::Start::launch;
    if (launched) static_cast<void>(launch_prefix(scene, participant));
    paths.push_back(launched ? find_executable(scene, participant) : "");
  }
  return paths;
}

std::vector<std::string> participant_names(const scene::Scene& scene) {
  std::vector<std::string> names;
  for (const auto& participant : scene.participants) names.push_back(participant.name);
  return names;
}

void require_capability(const PeerDescription& description, Capability needed, const std::string& activity) {
  if (description.has(needed)) return;
  const auto& has = description.capabilities;
  throw ConfigError(
      fmt::format("participant '{}' ({}) cannot take part in {}: it lacks the capability \"{}\" (it has: "
                  "{}); choose another protocol or another solver",
                  description.participant, name_of(description.role), activity, name_of(needed),
                  has.empty() ? "none" : fmt::format("{}", fmt::join(has, ", "))));
}

void check_capabilities(const scene::ProtocolTraits& protocol, const std::vector<PeerDescription>& descriptions) {
  int implicit = 0;
  for (const auto& description : descriptions) {
    const bool is_implicit = description.role == Role::implicit_solver;
    implicit += is_implicit ? 1 : 0;
    for (const auto needed : is_implicit ? protocol.implicit_capabilities : protocol.explicit_capabilities) {
      require_capability(description, needed, fmt::format("protocol {}", protocol.name));
    }
  }
  if (protocol.coupled() && implicit != 1) {
    throw ConfigError(
        fmt::format("protocol {} needs exactly one implicit participant, the scene has {}", protocol.name, implicit));
  }
}

void check_contact_owner(const scene::Problem& problem, const std::vector<PeerDescription>& descriptions) {
  if (problem.contacts.empty()) return;
  const bool hybrid = problem.scene.coupling.protocol.coupled();
  for (const auto& description : descriptions) {
    const bool integrates_contact = description.role == Role::implicit_solver || !hybrid;
    if (description.contact_owner == integrates_contact) continue;
    throw ConfigError(fmt::format(
        "participant '{}' ({}) described 'contact_owner' = {}, allowed: {}; of the contact of this scene {}",
        description.participant, name_of(description.role), description.contact_owner, integrates_contact,
        integrates_contact ? "it integrates the nodes, and nobody else would keep the surfaces apart"
                           : "the implicit participant integrates the nodes, and enforces it"));
  }
}

void check_declared_steps(const scene::Problem& problem, const std::vector<PeerDescription>& descriptions) {
  constexpr double found_twice = 1e-6;  // of an eigenvalue
  const auto& scene = problem.scene;
  for (const auto& description : descriptions) {
    const int substeps = scene.participant(description.participant).substeps;
    const double step_s = problem.clock.largest_size_s() / substeps;
    const double critical_s = description.critical_time_step_s;
    if (description.role != Role::explicit_solver || critical_s <= 0.0 || step_s <= (1.0 + found_twice) * critical_s)
      continue;
    throw ConfigError(fmt::format(
        "participant '{}' declares the critical time step {:.6g} s, found a step of {:.6g} s; allowed: time.step_s = "
        "{:.3g} or less{}",
        description.participant, critical_s, step_s, 0.9 * substeps * critical_s,
        scene.coupling.protocol.dual ? ", or more substeps" : ""));
  }
}

std::vector<PeerDescription> joined(const scene::Problem& problem, std::vector<PeerDescription> descriptions) {
  for (auto& description : descriptions) {
    if (description.role == Role::explicit_solver)
      description.substeps = problem.scene.participant(description.participant).substeps;
    for (const auto& joint : problem.joints) {
      const auto& bodies = description.bodies;
      const auto index = static_cast<double>(std::find(bodies.begin(), bodies.end(), joint.foreign) - bodies.begin());
      auto& of_nodes = description.interface_body.data;
      if (std::find(of_nodes.begin(), of_nodes.end(), index) == of_nodes.end()) continue;
      std::replace(of_nodes.begin(), of_nodes.end(), index, static_cast<double>(bodies.size()));
      description.bodies.push_back(problem.bodies[static_cast<std::size_t>(joint.body)].name);
    }
  }
  return descriptions;
}

ProcessSet make_process_set(const scene::Problem& problem, const std::vector<scene::ParticipantPlan>& plans,
                            const std::vector<std::string>& executables, const ResultsDirectory& results,
                            const std::string& run_id) {
  const auto& scene = problem.scene;
  std::vector<Member> members;
  for (std::size_t p = 0; p < executables.size(); ++p) {
    const auto& participant = scene.participants[p];
    members.push_back(member_of(scene, participant, executables[p], results));
    if (participant.foreign() || participant.start == scene::Start::by_hand) continue;
    // None of an implicit one: whether it can integrate its elements explicitly the plan knows, too.
    const double critical_s = std::isfinite(plans[p].critical_time_step_s) ? plans[p].critical_time_step_s : 0.0;
    members.back().arguments.insert(members.back().arguments.end(), {"--critical-step", fmt::format("{}", critical_s)});
    if (!pays_inside(scene, participant)) continue;
    members.back().log_path.clear();
    members.back().inside = [&problem, name = participant.name, critical_s] {
      return make_inside()(problem, name, critical_s);
    };
  }
  const RunIdentity run{run_id,
                        scene.sha256,
                        scene.coupling.timeout_s,
                        problem.clock,
                        scene.coupling.transport,
                        scene.where("coupling.transport"),
                        largest_message(problem),
                        scene.coupling.start_timeout_s};
  return {std::move(members), run, listen_endpoint(scene.coupling)};
}

}  // namespace ricochet::coupler
